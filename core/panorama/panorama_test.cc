// Panoramas: their colours, how they are turned and read, and how they are told from other
// pictures.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/files/image_file.h"
#include "core/geometry/sphere.h"
#include "core/panorama/panorama_rotation.h"
#include "core/panorama/panorama_sampler.h"
#include "core/panorama/picture_look.h"
#include "core/panorama/srgb.h"
#include "core/room/gain_fields.h"

namespace raywalk {
namespace {

TEST(SrgbTest, KnowsTheStandardsValues) {
  EXPECT_DOUBLE_EQ(linear_from_srgb_level(0.0), 0.0);
  EXPECT_NEAR(linear_from_srgb_level(255.0), 1.0, 1e-12);
  // Middle grey of 18 % reflectance is level 117.6; level 128 is 21.6 % light.
  EXPECT_NEAR(srgb_level_from_linear(0.18), 117.6, 0.1);
  EXPECT_NEAR(linear_from_srgb_level(128.0), 0.2159, 1e-4);
}

// The standard's rounded constants leave a step of a few millionths where its two parts meet.
TEST(SrgbTest, RoundTripGivesTheLevel) {
  for (double level = 0.0; level <= 255.0; level += 0.25) {
    EXPECT_NEAR(srgb_level_from_linear(linear_from_srgb_level(level)), level, 1e-4);
  }
}

TEST(SrgbTest, ScaledLightIsAnAffineFunctionOfTheLevelAboveTheToe) {
  for (const double factor : {0.6, 0.9, 1.2, 2.0}) {
    for (double level = 40.0; level <= 120.0; level += 8.0) {
      const double scaled = srgb_level_from_linear(factor * linear_from_srgb_level(level));
      const double root = std::pow(factor, 1.0 / kSrgbExponent);
      EXPECT_NEAR(scaled, (level + kSrgbShift_levels) * root - kSrgbShift_levels, 1e-9);
    }
  }
}

cv::Mat grey_panorama(int width) {
  return cv::Mat(width, width / 2, CV_8UC3, cv::Scalar(100, 100, 100));
}

// Of four rows of patches around, one is 1.4 times as light.
GainField with_light_row(int row) {
  GainField gains;
  gains.local = cv::Mat(4, 2, CV_32FC3, cv::Scalar(1, 1, 1));
  gains.local.row(row) = cv::Scalar(1.4, 1.4, 1.4);
  return gains;
}

TEST(GainFieldTest, LocalFactorsHoldInTheMiddleOfTheirPatchAndAreLinearBetween) {
  for (const int width : {32, 100, 1024}) {
    cv::Mat colours = grey_panorama(width);
    apply_gains(with_light_row(1), &colours);
    const auto level = [&](double share) {
      return colours.at<cv::Vec3b>(static_cast<int>(share * width), width / 4)[0];
    };
    // Middles of the patches are at 1/8, 3/8, 5/8 and 7/8 of the panorama.
    const double tolerance = 100.0 * 0.4 * 4 / width + 1.0;
    for (const auto& [share, expected] :
         {std::pair(0.125, 100.0), {0.375, 140.0}, {0.25, 120.0}, {0.5, 120.0}, {0.75, 100.0}}) {
      EXPECT_NEAR(level(share), expected, tolerance) << width;
    }
  }
}

TEST(GainFieldTest, TheSeamIsNoEdgeAndThePictureIsAlsoMultipliedAsAWhole) {
  cv::Mat colours = grey_panorama(256);
  GainField gains = with_light_row(3);
  gains.whole = {0.5F, 1.0F, 1.5F};
  apply_gains(gains, &colours);
  for (const int column : {0, 255}) {
    const cv::Vec3b seam = colours.at<cv::Vec3b>(column, 64);
    EXPECT_LE(cv::norm(seam, cv::Vec3b(60, 120, 180), cv::NORM_INF), 1.0) << seam;
  }
}

constexpr PanoramaSize kSampledSize{64, 32};

TEST(WrappedBorderTest, ContinuesAcrossSeamAndPoles) {
  cv::Mat_<ushort> image(2, 4);
  for (int i = 0; i < 8; ++i) image(i / 4, i % 4) = static_cast<ushort>(1000 + i);
  const cv::Mat_<ushort> expected = (cv::Mat_<ushort>(4, 6) << 1001, 1002, 1003, 1000, 1001, 1002,
                                     1003, 1000, 1001, 1002, 1003, 1000,  //
                                     1007, 1004, 1005, 1006, 1007, 1004,  //
                                     1005, 1006, 1007, 1004, 1005, 1006);
  EXPECT_EQ(cv::norm(with_wrapped_border(image, 1), expected, cv::NORM_INF), 0.0);
}

TEST(NearestPixelTest, IsTheOneThatTheDirectionLiesInAlsoAroundTheSeam) {
  const cv::Size size(kSampledSize.width, kSampledSize.height);
  EXPECT_EQ(nearest_pixel(PixelPosition{63.6, 5.2}, size), cv::Point(0, 5));
  EXPECT_EQ(nearest_pixel(PixelPosition{-0.4, 31.4}, size), cv::Point(0, 31));
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

// Seam and poles included; 3 of 255 is the rounding of source and result and the cubic's residual
// at the poles, where 128 rows sample the pattern coarsely across the pole.
TEST(RotatePanorama, ShowsTheWorldWhateverTheAttitude) {
  const cv::Mat world = seen_by_camera(Eigen::Matrix3d::Identity());
  for (const Attitude& attitude :
       {degrees(0, 0, 0), degrees(90, 0, 0), degrees(-37, 0, 0), degrees(0, 30, 0),
        degrees(0, 90, 0), degrees(0, 0, 25), degrees(0, 0, 180), degrees(120, -50, 77),
        degrees(1.5, -0.7, 0.4)}) {
    const Eigen::Matrix3d rotation = world_from_camera(attitude);
    const cv::Mat rotated = rotate_panorama(seen_by_camera(rotation), rotation);
    EXPECT_LE(cv::norm(rotated, world, cv::NORM_INF), 3.0)
        << degrees_from_radians(attitude.yaw_rad) << " "
        << degrees_from_radians(attitude.pitch_rad);
  }
  const cv::Mat unturned = rotate_panorama(world, Eigen::Matrix3d::Identity());
  EXPECT_EQ(cv::norm(unturned, world, cv::NORM_INF), 0.0);
}

TEST(RotateDistanceMap, KeepsValuesAndMovesThem) {
  cv::Mat map(kRotatedSize.height, kRotatedSize.width, CV_16UC1);
  map.colRange(0, 128).setTo(1000);
  map.colRange(128, 256).setTo(60000);
  const cv::Mat rotated = rotate_distance_map(map, world_from_camera(degrees(90, 0, 0)));
  cv::Mat quarter_on;
  cv::hconcat(map.colRange(192, 256), map.colRange(0, 192), quarter_on);
  EXPECT_EQ(cv::norm(rotated, quarter_on, cv::NORM_INF), 0.0);
  const cv::Mat oblique = rotate_distance_map(map, world_from_camera(degrees(10, 70, -30)));
  EXPECT_EQ(cv::countNonZero((oblique != 1000) & (oblique != 60000)), 0);
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

constexpr PanoramaSize kSize{512, 256};

// A light, busy scene: grey levels about 128 by direction.
class Scene {
 public:
  explicit Scene(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    for (auto& [along, phase] : waves_) {
      along = 6.0 * Eigen::Vector3d(number(random), number(random), number(random));
      phase = 3.0 * number(random);
    }
  }
  double at(const Eigen::Vector3d& direction) const {
    double level = 128.0;
    for (const auto& [along, phase] : waves_) {
      level += 25.0 * std::sin(along.dot(direction) + phase);
    }
    return level;
  }

 private:
  std::array<std::pair<Eigen::Vector3d, double>, 6> waves_{};
};

cv::Mat drawn(const std::function<double(int, int)>& level) {
  cv::Mat picture(kSize.height, kSize.width, CV_8UC1);
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      picture.at<uchar>(v, u) = cv::saturate_cast<uchar>(level(u, v));
    }
  }
  return picture;
}

cv::Mat panorama_of(const Scene& scene) {
  return drawn([&](int u, int v) {
    return scene.at(direction_from_angles(angles_from_pixel({double(u), double(v)}, kSize)));
  });
}

// Two circles of `radius` half heights, each of 190 degrees.
cv::Mat dual_fisheye_of(const Scene& scene, double radius) {
  return drawn([&](int u, int v) {
    const bool back = u >= kSize.height;
    const double half = 0.5 * kSize.height;
    const double x = (u % kSize.height + 0.5 - half) / half, y = (v + 0.5 - half) / half;
    const double from_centre = std::hypot(x, y);
    if (from_centre > radius) return 0.0;
    const double angle = from_centre / radius * 95.0 * M_PI / 180.0;
    const double side = std::sin(angle) / std::max(from_centre, 1e-9);
    const Eigen::Vector3d direction(side * x, side * y, std::cos(angle));
    return scene.at(back ? Eigen::Vector3d(-direction.x(), direction.y(), -direction.z())
                         : direction);
  });
}

cv::Mat with_noise(const cv::Mat& picture, double sigma, unsigned seed) {
  cv::RNG random(seed);
  cv::Mat noise(picture.size(), CV_16SC1), sum;
  random.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::add(picture, noise, sum, cv::noArray(), CV_8U);
  return sum;
}

TEST(PictureLookProperty, GeneratedPicturesAreRecognisedAlsoWithNoise) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    const Scene scene(seed);
    for (const double sigma : {0.0, 3.0}) {
      const auto seen = [&](const cv::Mat& picture) {
        return look_at_picture(with_noise(picture, sigma, seed));
      };
      EXPECT_EQ(seen(panorama_of(scene)), PictureKind::kPanorama) << seed << ' ' << sigma;
      EXPECT_EQ(seen(dual_fisheye_of(scene, 0.93 + 0.003 * seed)), PictureKind::kDualFisheye)
          << seed << ' ' << sigma;
    }
  }
}

TEST(PictureLookProperty, DarkOrNoisyPicturesAreNeverTakenForTheOtherKind) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Scene scene(seed);
    const cv::Mat panorama = panorama_of(scene), fisheyes = dual_fisheye_of(scene, 0.97);
    for (const double light : {0.5, 0.1, 0.02}) {
      for (const double sigma : {1.0, 10.0, 60.0}) {
        const auto seen = [&](const cv::Mat& picture) {
          return look_at_picture(with_noise(picture * light, sigma, seed));
        };
        EXPECT_NE(seen(panorama), PictureKind::kDualFisheye) << seed;
        EXPECT_NE(seen(fisheyes), PictureKind::kPanorama) << seed;
      }
    }
  }
}

TEST(PictureLook, IsUnclearWhereNothingTells) {
  const Scene scene(1);
  const cv::Mat panorama = panorama_of(scene);
  cv::Mat cut = panorama.clone(), shifted = panorama.clone();
  panorama.rowRange(64, 192).copyTo(cut.rowRange(0, 128));
  for (int v = 0; v < shifted.rows; ++v) {  // left and right edges apart
    for (int u = 0; u < 32; ++u) shifted.at<uchar>(v, u) = static_cast<uchar>((7 * v) % 251);
  }
  const std::vector<std::pair<std::string, cv::Mat>> cases = {
      {"nothing", {}},
      {"black", drawn([](int, int) { return 0.0; })},
      {"white", drawn([](int, int) { return 255.0; })},
      {"a gradient from sky to ground", drawn([](int, int v) { return double(v); })},
      {"noise", with_noise(drawn([](int, int) { return 128.0; }), 60.0, 1)},
      {"another aspect ratio", panorama.colRange(0, 400)},
      {"a band of a panorama", cut},
      {"edges apart", shifted},
      {"a single circle", dual_fisheye_of(scene, 0.97).colRange(0, 256)},
      {"two lamps in the dark", drawn([](int u, int v) {
         return 255.0 * std::exp(-0.002 * (std::pow(u % 256 - 128, 2) + std::pow(v - 128, 2)));
       })},
      {"a few pixels", cv::Mat(32, 64, CV_8UC1, cv::Scalar(9))}};
  for (const auto& [what, picture] : cases) {
    EXPECT_EQ(look_at_picture(picture), PictureKind::kUnclear) << what;
  }
}

TEST(PictureLook, PanoramasOfTheEmbeddedRoomAreNotTakenForFisheyes) {
  int recognised = 0, all = 0;
  const std::filesystem::path folder = std::filesystem::path(RAYWALK_TEST_ROOM) / "capture";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const PictureKind kind = look_at_picture(read_picture(entry.path()));
    EXPECT_NE(kind, PictureKind::kDualFisheye) << entry.path();
    recognised += kind == PictureKind::kPanorama ? 1 : 0;
    ++all;
  }
  EXPECT_GE(recognised, all * 8 / 10);
}

TEST(PictureLook, FilesAreDecodedAndOthersAreUnclear) {
  std::vector<uchar> file;
  cv::imencode(".jpg", dual_fisheye_of(Scene(3), 0.97), file);
  EXPECT_EQ(look_at_picture(std::as_bytes(std::span(file))), PictureKind::kDualFisheye);
  const std::string text = "shot 3";
  EXPECT_EQ(look_at_picture(std::as_bytes(std::span(text))), PictureKind::kUnclear);
  EXPECT_EQ(look_at_picture(std::span<const std::byte>{}), PictureKind::kUnclear);
}

}  // namespace
}  // namespace raywalk
