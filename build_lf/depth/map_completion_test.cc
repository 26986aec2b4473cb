#include "build_lf/depth/map_completion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "core/room/distance_volume.h"

namespace raywalk::build_lf {
namespace {

constexpr PanoramaSize kSize{256, 128};
constexpr double kSurfaceTolerance_per_m = 0.02;

// A map of planes: `normal_of` gives n / d of the plane n . X = d that a direction meets.
struct TestMap {
  InverseDistanceMap map{{}, {0, 0, 0}, kSize, {}, {}};
  cv::Mat colours{kSize.width, kSize.height, CV_8UC3, cv::Scalar(90, 90, 90)};
  std::vector<float> truth{};

  explicit TestMap(const std::function<double(const Eigen::Vector3d&)>& omega_of) {
    for (int theta = 0; theta < kSize.width; ++theta) {
      for (int phi = 0; phi < kSize.height; ++phi) {
        const auto angles = angles_from_pixel({double(theta), double(phi)}, kSize);
        truth.push_back(static_cast<float>(omega_of(direction_from_angles(angles))));
      }
    }
    map.omega = truth;
    map.confidence.assign(truth.size(), 255);
  }
  // Makes the pixels of a rectangle unknown, with wrong values.
  void forget(const cv::Rect& thetas_and_phis) {
    for (int theta = thetas_and_phis.x; theta < thetas_and_phis.br().x; ++theta) {
      for (int phi = thetas_and_phis.y; phi < thetas_and_phis.br().y; ++phi) {
        const size_t pixel = pixel_index(theta, phi, kSize);
        map.confidence[pixel] = 10;
        map.omega[pixel] = 5.0f;
      }
    }
  }
  double largest_error(const cv::Rect& where) const {
    double largest = 0.0;
    for (int theta = where.x; theta < where.br().x; ++theta) {
      for (int phi = where.y; phi < where.br().y; ++phi) {
        const size_t pixel = pixel_index(theta, phi, kSize);
        largest = std::max(largest, std::fabs(double(map.omega[pixel]) - truth[pixel]));
      }
    }
    return largest;
  }
};

// A wall at z = 2 m seen at a slant of up to 60 degrees, in front of which everything else is far.
double wall(const Eigen::Vector3d& direction) { return std::max(0.0, direction.z() / 2.0); }

TEST(MapCompletionTest, AGapInASlantedWallIsContinuedAsAPlane) {
  TestMap test(wall);
  const cv::Rect gap(165, 50, 14, 14);  // 52 to 72 degrees from the wall's normal
  test.forget(gap);
  complete_map(test.colours, {}, kSurfaceTolerance_per_m, &test.map);
  EXPECT_LT(test.largest_error(gap), kSurfaceTolerance_per_m);
  // Around its middle, the wall is seen on all sides.
  for (int theta = gap.x + 6; theta < gap.br().x - 6; ++theta) {
    EXPECT_GE(test.map.confidence[pixel_index(theta, 56, kSize)], kMinConfidence) << theta;
    EXPECT_LE(test.map.confidence[pixel_index(theta, 56, kSize)], 127) << theta;
  }
}

// Most of the pixels looked at lie beyond so small a gap, on all sides.
TEST(MapCompletionTest, ASmallGapIsTrusted) {
  TestMap test(wall);
  const cv::Rect gap(165, 52, 3, 3);
  test.forget(gap);
  complete_map(test.colours, {}, kSurfaceTolerance_per_m, &test.map);
  for (int theta = gap.x; theta < gap.br().x; ++theta) {
    EXPECT_GE(test.map.confidence[pixel_index(theta, 53, kSize)], kMinConfidence) << theta;
    EXPECT_LE(test.map.confidence[pixel_index(theta, 53, kSize)], 127) << theta;
  }
}

TEST(MapCompletionTest, ColoursTellWhichSurfaceAPixelBelongsTo) {
  // A post at 1 m in front of a wall at 4 m, at the same place in colours and distances.
  const auto post = [](const Eigen::Vector3d& direction) {
    return std::fabs(std::atan2(direction.x(), direction.z())) < 0.15 ? 1.0 : 0.25;
  };
  TestMap test(post);
  for (int theta = 0; theta < kSize.width; ++theta) {
    if (test.truth[pixel_index(theta, 64, kSize)] == 1.0f) {
      test.colours.row(theta) = cv::Scalar(200, 60, 60);
    }
  }
  const cv::Rect gap(112, 58, 32, 8);  // across both edges
  test.forget(gap);
  complete_map(test.colours, {}, kSurfaceTolerance_per_m, &test.map);
  EXPECT_LT(test.largest_error(gap), kSurfaceTolerance_per_m);
}

// At the outline of a thing, only one side tells its distance: that is a guess, which views must
// not rely on.
TEST(MapCompletionTest, WhatLiesBesideAllThatIsKnownStaysDoubted) {
  // A red box, 0.5 rad to either side, in front of a wall.
  TestMap test([](const Eigen::Vector3d& direction) {
    return std::fabs(std::atan2(direction.x(), direction.z())) < 0.5 ? 1.0 : 0.25;
  });
  int first = -1, end = -1;  // columns of the box
  for (int theta = 0; theta < kSize.width; ++theta) {
    if (test.truth[pixel_index(theta, 64, kSize)] != 1.0f) continue;
    if (first < 0) first = theta;
    end = theta + 1;
    test.colours.row(theta) = cv::Scalar(60, 60, 200);
  }
  test.forget({first, 0, 2, kSize.height});
  test.forget({(first + end) / 2, 0, 2, kSize.height});
  complete_map(test.colours, {}, kSurfaceTolerance_per_m, &test.map);
  const auto confidence = [&](int theta) {
    return test.map.confidence[pixel_index(theta, 64, kSize)];
  };
  EXPECT_LT(confidence(first), kMinConfidence);
  EXPECT_GE(confidence((first + end) / 2), kMinConfidence);
  EXPECT_LT(test.largest_error({first, 60, 2, 8}), kSurfaceTolerance_per_m);
}

TEST(MapCompletionTest, ConfidentPixelsStayAsTheyAre) {
  TestMap test(wall);
  const InverseDistanceMap before = test.map;
  complete_map(test.colours, {}, kSurfaceTolerance_per_m, &test.map);
  EXPECT_EQ(test.map.omega, before.omega);
  EXPECT_EQ(test.map.confidence, before.confidence);
}

TEST(MapCompletionTest, SurroundingsThatContradictEachOtherDecideNothing) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> omega(0.0, 3.0);
  TestMap test([&](const Eigen::Vector3d&) { return omega(random); });
  const cv::Rect gap(100, 60, 10, 10);
  test.forget(gap);
  complete_map(test.colours, {}, kSurfaceTolerance_per_m, &test.map);
  for (int theta = gap.x; theta < gap.br().x; ++theta) {
    EXPECT_LT(test.map.confidence[pixel_index(theta, 65, kSize)], kMinConfidence);
  }
}

TEST(MapCompletionTest, NothingIsConcludedFromNothing) {
  TestMap test(wall);
  test.forget({0, 0, kSize.width, kSize.height});
  complete_map(test.colours, {}, kSurfaceTolerance_per_m, &test.map);
  for (const std::uint8_t confidence : test.map.confidence) EXPECT_EQ(confidence, 10);
}

// What a mask hides is not the scene: its colours must not decide.
TEST(MapCompletionTest, MaskedPixelsNeitherTellNorChange) {
  TestMap test(wall);
  const cv::Rect masked(120, 40, 20, 20);
  test.forget(masked);
  cv::Mat valid(kSize.width, kSize.height, CV_8UC1, cv::Scalar(255));
  valid(cv::Rect(masked.y, masked.x, masked.height, masked.width)) = cv::Scalar(0);
  complete_map(test.colours, valid, kSurfaceTolerance_per_m, &test.map);
  EXPECT_EQ(test.map.confidence[pixel_index(130, 50, kSize)], 10);
}

TEST(MapCompletionTest, ThePolesAndTheSeamAreLikeAnyPlace) {
  // A floor 1.5 m below.
  TestMap test(
      [](const Eigen::Vector3d& direction) { return std::max(0.0, -direction.y() / 1.5); });
  const cv::Rect pole(0, 122, kSize.width, 6), left(0, 90, 5, 8), right(251, 90, 5, 8);
  for (const cv::Rect& gap : {pole, left, right}) test.forget(gap);
  complete_map(test.colours, {}, kSurfaceTolerance_per_m, &test.map);
  for (const cv::Rect& gap : {pole, left, right}) {
    EXPECT_LT(test.largest_error(gap), kSurfaceTolerance_per_m);
  }
}

}  // namespace
}  // namespace raywalk::build_lf
