#include "calibrate/grid/crossing_matches.h"

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <random>

#include "calibrate/grid/crossing_figures.h"
#include "calibrate/grid/test_room.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using testing::HasSubstr;

TEST(CrossingMatchesTest, MatchesShowTheSamePointsOfTheRoom) {
  const TestDirectory directory;
  const RoomCapture capture = capture_room(directory.path(), {});
  const auto crossings = find_crossing_matches(capture.set, nominal_poses(capture.set), {}, {});
  ASSERT_EQ(crossings.size(), 1U);
  const std::vector<CrossingMatch>& matches = crossings[0].matches;
  ASSERT_GT(matches.size(), 500U);
  int right = 0, held_out = 0;
  for (const CrossingMatch& match : matches) {
    EXPECT_EQ(match.ray_x.origin_m, Eigen::Vector3d(0, 0, 0));
    // At the true poses, within two pixels of 512 from the epipolar line.
    const double error = epipolar_error_rad(match, capture.truth, CrossingFit{});
    if (error < 2.0 * kTwoPi / 512) ++right;
    if (match.held_out) ++held_out;
  }
  EXPECT_GT(right, 0.8 * static_cast<double>(matches.size()));
  EXPECT_NEAR(held_out, 0.5 * static_cast<double>(matches.size()),
              0.15 * static_cast<double>(matches.size()));
}

TEST(CrossingMatchesTest, MaskAndSeamAreExcluded) {
  const TestDirectory directory;
  const RoomCapture capture = capture_room(directory.path(), {});
  // The lower half is masked.
  cv::Mat mask(capture.set.frame.height, capture.set.frame.width, CV_8UC1, cv::Scalar(255));
  mask.rowRange(capture.set.frame.height / 2, capture.set.frame.height).setTo(0);
  DualFisheyeLayout lenses = simple_dual_fisheye(capture.set.frame);
  lenses.front_position_m = {0, 0, 0.005};
  lenses.back_position_m = {0, 0, -0.005};
  const auto crossings =
      find_crossing_matches(capture.set, nominal_poses(capture.set), mask, lenses);
  ASSERT_GT(crossings[0].matches.size(), 100U);
  for (const CrossingMatch& match : crossings[0].matches) {
    for (const MatchRay& ray : {match.ray_x, match.ray_z}) {
      EXPECT_GT(ray.bearing.y(), 0.0);
      EXPECT_GT(std::fabs(ray.bearing.z()), std::sin(radians_from_degrees(3.9)));
      EXPECT_EQ(ray.origin_m.z(), ray.bearing.z() > 0.0 ? 0.005 : -0.005);
    }
  }
}

TEST(CrossingMatchesTest, HeldOutPatchesCoverHalfOfTheSphere) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  int held_out = 0, changes = 0;
  constexpr int kDirections = 20000;
  for (int i = 0; i < kDirections; ++i) {
    const Eigen::Vector3d direction =
        Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    const Eigen::Vector3d near =
        (direction + radians_from_degrees(0.5) * direction.unitOrthogonal()).normalized();
    held_out += in_held_out_patch(direction) ? 1 : 0;
    changes += in_held_out_patch(direction) != in_held_out_patch(near) ? 1 : 0;
  }
  EXPECT_NEAR(held_out, kDirections / 2, kDirections / 50);
  // A step of half a degree seldom leaves a patch of 11 degrees.
  EXPECT_LT(changes, kDirections / 8);
}

TEST(CrossingMatchesTest, AFrameOfAnotherSizeIsNamed) {
  const TestDirectory directory;
  const RoomCapture capture = capture_room(directory.path(), {.blank = true});
  cv::imwrite(capture.set.frames[4].file.string(), cv::Mat::zeros(64, 128, CV_8UC3));
  try {
    find_crossing_matches(capture.set, nominal_poses(capture.set), {}, {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(capture.set.frames[4].file.string()));
    EXPECT_THAT(error.what(), HasSubstr("another camera"));
  }
}

}  // namespace
}  // namespace raywalk::calibrate
