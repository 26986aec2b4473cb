#include "core/panorama/panorama_rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/geometry/sphere.h"
#include "core/panorama/panorama_sampler.h"

namespace raywalk {
namespace {

constexpr PanoramaSize kSampledSize{64, 32};

// Each channel is an affine function of the direction, so it has no seam and no pole.
cv::Vec3f smooth_color(const Eigen::Vector3d& direction) {
  return cv::Vec3f(static_cast<float>(128.0 + 100.0 * direction.x()),
                   static_cast<float>(128.0 + 100.0 * direction.y()),
                   static_cast<float>(128.0 + 100.0 * direction.z()));
}

cv::Mat smooth_panorama() {
  cv::Mat image(kSampledSize.height, kSampledSize.width, CV_8UC3);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const SphereAngles angles = angles_from_pixel({double(u), double(v)}, kSampledSize);
      const cv::Vec3f color = smooth_color(direction_from_angles(angles));
      for (int c = 0; c < 3; ++c) {
        image.at<cv::Vec3b>(v, u)[c] = cv::saturate_cast<uchar>(color[c]);
      }
    }
  }
  return image;
}

TEST(PanoramaSamplerTest, ReadsAcrossSeamAndPoles) {
  const PanoramaSampler sampler(smooth_panorama());
  for (double phi = -90.0; phi <= 90.0; phi += 3.0) {
    for (double theta = -180.0; theta < 180.0; theta += 4.5) {
      const Eigen::Vector3d direction =
          direction_from_angles({radians_from_degrees(theta), radians_from_degrees(phi)});
      const cv::Vec3f difference = sampler.at(direction) - smooth_color(direction);
      // Half a level is the rounding of the pixels; cubics may double it.
      EXPECT_LT(cv::norm(difference, cv::NORM_INF), 1.2) << theta << " " << phi;
    }
  }
}

TEST(WrappedPixelTest, RowsBeyondAPoleAreSeenHalfATurnAway) {
  const cv::Size size(8, 4);
  EXPECT_EQ(wrapped_pixel(-1, 2, size), cv::Point(7, 2));
  EXPECT_EQ(wrapped_pixel(8, 2, size), cv::Point(0, 2));
  EXPECT_EQ(wrapped_pixel(1, -1, size), cv::Point(5, 0));
  EXPECT_EQ(wrapped_pixel(6, 4, size), cv::Point(2, 3));
}

TEST(WrappedBorderTest, ContinuesAcrossSeamAndPoles) {
  cv::Mat_<ushort> image(2, 4);
  for (int i = 0; i < 8; ++i) image(i / 4, i % 4) = static_cast<ushort>(1000 + i);
  const cv::Mat_<ushort> expected = (cv::Mat_<ushort>(4, 6) << 1001, 1002, 1003, 1000, 1001, 1002,
                                     1003, 1000, 1001, 1002, 1003, 1000,  //
                                     1007, 1004, 1005, 1006, 1007, 1004,  //
                                     1005, 1006, 1007, 1004, 1005, 1006);
  EXPECT_EQ(cv::norm(with_wrapped_border(image, 1), expected, cv::NORM_INF), 0.0);
}

TEST(NearestPixelTest, IsTheOneThatTheDirectionLiesIn) {
  const cv::Size size(kSampledSize.width, kSampledSize.height);
  for (double phi = -90.0; phi <= 90.0; phi += 1.5) {
    for (double theta = -180.0; theta < 180.0; theta += 2.25) {
      const Eigen::Vector3d direction =
          direction_from_angles({radians_from_degrees(theta), radians_from_degrees(phi)});
      const cv::Point pixel = nearest_pixel(direction, size);
      ASSERT_TRUE(cv::Rect({}, size).contains(pixel)) << theta << " " << phi;
      const Eigen::Vector3d centre = direction_from_angles(
          angles_from_pixel({double(pixel.x), double(pixel.y)}, kSampledSize));
      // Half the diagonal of a pixel.
      EXPECT_LT((centre - direction).norm(), 0.71 * kTwoPi / kSampledSize.width)
          << theta << " " << phi;
    }
  }
}

TEST(NearestPixelTest, GoesRoundAtTheSeam) {
  const cv::Size size(kSampledSize.width, kSampledSize.height);
  EXPECT_EQ(nearest_pixel(PixelPosition{63.6, 5.2}, size), cv::Point(0, 5));
  EXPECT_EQ(nearest_pixel(PixelPosition{-0.4, 5.2}, size), cv::Point(0, 5));
  EXPECT_EQ(nearest_pixel(PixelPosition{-0.4, 31.4}, size), cv::Point(0, 31));
}

constexpr PanoramaSize kRotatedSize{256, 128};

Attitude degrees(double yaw, double pitch, double roll) {
  return {radians_from_degrees(yaw), radians_from_degrees(pitch), radians_from_degrees(roll)};
}

// A smooth world: each channel waves along one axis of the direction.
cv::Vec3b world_colour(const Eigen::Vector3d& direction) {
  const auto channel = [](double along) {
    return cv::saturate_cast<uchar>(128.0 + 60.0 * along + 40.0 * std::sin(5.0 * along));
  };
  return {channel(direction.x()), channel(direction.y()), channel(direction.z())};
}

// That world seen by a camera with the given attitude.
cv::Mat seen_by_camera(const Eigen::Matrix3d& rotation) {
  cv::Mat image(kRotatedSize.height, kRotatedSize.width, CV_8UC3);
  for (int v = 0; v < kRotatedSize.height; ++v) {
    for (int u = 0; u < kRotatedSize.width; ++u) {
      const PixelPosition pixel{static_cast<double>(u), static_cast<double>(v)};
      const Eigen::Vector3d in_camera =
          direction_from_angles(angles_from_pixel(pixel, kRotatedSize));
      image.at<cv::Vec3b>(v, u) = world_colour(rotation * in_camera);
    }
  }
  return image;
}

double largest_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}

// Seam and poles included; 3 of 255 is the rounding of source and result and the cubic's residual
// at the poles, where 128 rows sample the pattern coarsely across the pole.
TEST(RotatePanorama, ShowsTheWorldWhateverTheAttitude) {
  const cv::Mat world = seen_by_camera(Eigen::Matrix3d::Identity());
  for (const Attitude& attitude :
       {degrees(0, 0, 0), degrees(90, 0, 0), degrees(-37, 0, 0), degrees(0, 30, 0),
        degrees(0, 90, 0), degrees(0, 0, 25), degrees(0, 0, 180), degrees(120, -50, 77),
        degrees(1.5, -0.7, 0.4)}) {
    const Eigen::Matrix3d rotation = world_from_camera(attitude);
    EXPECT_LE(largest_difference(rotate_panorama(seen_by_camera(rotation), rotation), world), 3.0)
        << degrees_from_radians(attitude.yaw_rad) << " "
        << degrees_from_radians(attitude.pitch_rad);
  }
}

TEST(RotatePanorama, NoRotationChangesNoPixel) {
  const cv::Mat original = seen_by_camera(Eigen::Matrix3d::Identity());
  EXPECT_EQ(largest_difference(rotate_panorama(original, Eigen::Matrix3d::Identity()), original),
            0.0);
}

TEST(RotateDistanceMap, KeepsValuesAndMovesThem) {
  cv::Mat map(kRotatedSize.height, kRotatedSize.width, CV_16UC1);
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) map.at<ushort>(v, u) = u < map.cols / 2 ? 1000 : 60000;
  }
  const cv::Mat rotated = rotate_distance_map(map, world_from_camera(degrees(90, 0, 0)));
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      EXPECT_EQ(rotated.at<ushort>(v, u), map.at<ushort>(v, (u + map.cols * 3 / 4) % map.cols));
    }
  }
  const cv::Mat oblique = rotate_distance_map(map, world_from_camera(degrees(10, 70, -30)));
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      const int value = oblique.at<ushort>(v, u);
      EXPECT_TRUE(value == 1000 || value == 60000) << value;
    }
  }
}

// The content under the mask does not affect the rotated panorama where its mask is not 0.
TEST(RotateMask, RotatedMaskCoversAllMaskedPixels) {
  cv::Mat mask(kRotatedSize.height, kRotatedSize.width, CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 110, kRotatedSize.width, 18)).setTo(0);
  mask(cv::Rect(0, 0, 9, 60)).setTo(0);
  mask(cv::Rect(200, 0, 30, 3)).setTo(0);
  const cv::Mat clean = seen_by_camera(Eigen::Matrix3d::Identity());
  cv::Mat painted = clean.clone();
  painted.setTo(cv::Scalar(255, 0, 255), mask == 0);
  for (const Attitude& attitude : {degrees(0.3, -0.2, 0.1), degrees(90, 0, 0), degrees(-37, 20, 0),
                                   degrees(0, 90, 0), degrees(120, -50, 77)}) {
    const Eigen::Matrix3d rotation = world_from_camera(attitude);
    const cv::Mat rotated = rotate_mask(mask, rotation);
    cv::Mat difference;
    cv::absdiff(rotate_panorama(clean, rotation), rotate_panorama(painted, rotation), difference);
    difference.setTo(cv::Scalar::all(0), rotated == 0);
    EXPECT_EQ(cv::norm(difference, cv::NORM_INF), 0.0);
    // Only a border of about two pixels is lost: the solid angle is at most that of the mask
    // dilated by three.
    const auto solid_angle = [](const cv::Mat& of) {
      double sum = 0.0;
      for (int v = 0; v < of.rows; ++v) {
        sum += cv::countNonZero(of.row(v) == 0) * std::sin((v + 0.5) / of.rows * kPi);
      }
      return sum;
    };
    cv::Mat grown;
    cv::copyMakeBorder(mask, grown, 0, 0, 3, 3, cv::BORDER_WRAP);
    cv::erode(grown, grown, cv::Mat::ones(7, 7, CV_8UC1));
    EXPECT_GE(solid_angle(rotated), 0.99 * solid_angle(mask));
    EXPECT_LE(solid_angle(rotated), solid_angle(grown.colRange(3, 3 + kRotatedSize.width)));
  }
}

}  // namespace
}  // namespace raywalk
