#include "calibrate/lens/motion_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/test_error.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

Vector3d random_direction(std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(*random), normal(*random), normal(*random)).normalized();
}

// Points two metres away, seen before and after a motion; a share of the matches is wrong.
std::vector<BearingPair> seen_around(const Vector3d& motion_m, double wrong_share,
                                     std::mt19937_64* random) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const Eigen::Matrix3d turn = world_from_camera({0.02, -0.01, 0.015});
  std::vector<BearingPair> seen;
  for (int i = 0; i < 300; ++i) {
    const Vector3d before = random_direction(random);
    Vector3d after = turn * (2.0 * before - motion_m).normalized();
    if (share(*random) < wrong_share)
      after = (before + 0.3 * random_direction(random)).normalized();
    seen.push_back({before, after});
  }
  return seen;
}

TEST(MotionCheckTest, DirectionIsRobustToWrongMatchesAndRotations) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20; ++i) {
    const Vector3d motion = random_direction(&random);
    const auto seen = motion_direction(seen_around(0.3 * motion, 0.3, &random));
    ASSERT_TRUE(seen);
    EXPECT_GT(seen->dot(motion), std::cos(radians_from_degrees(20.0)));
  }
  // Without agreement there is none.
  EXPECT_FALSE(motion_direction(seen_around({0.3, 0, 0}, 1.0, &random)));
  EXPECT_FALSE(motion_direction({}));
}

std::string complaint(const std::vector<MotionComparison>& motions) {
  return error_of([&] { require_motion_as_planned(motions); });
}

TEST(MotionCheckTest, ErrorsNameTheCause) {
  const Vector3d x = Vector3d::UnitX(), z = Vector3d::UnitZ();
  const Vector3d slanted = Vector3d(1, 0, 0.4).normalized();
  EXPECT_EQ(complaint({{x, slanted}, {z, z}}), "no error");
  EXPECT_EQ(complaint({}), "no error");
  EXPECT_THAT(complaint({{x, -x}, {z, -z}}), HasSubstr("swapped"));
  EXPECT_THAT(complaint({{x, -x}, {z, z}}), HasSubstr("mirrored"));
  EXPECT_THAT(complaint({{x, x}, {z, -z}}), HasSubstr("mirrored"));
  EXPECT_THAT(complaint({{x, z}, {z, -x}}), HasSubstr("90 degrees"));
}

}  // namespace
}  // namespace raywalk::calibrate
