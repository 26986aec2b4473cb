#include "core/panorama/panorama_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

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

}  // namespace
}  // namespace raywalk
