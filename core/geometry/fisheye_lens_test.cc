#include "core/geometry/fisheye_lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace raywalk {
namespace {

using Eigen::Vector3d;

Vector3d at_angle(double off_axis_rad, double around_rad) {
  return {std::sin(off_axis_rad) * std::cos(around_rad),
          std::sin(off_axis_rad) * std::sin(around_rad), std::cos(off_axis_rad)};
}

TEST(FisheyeLensTest, EquidistantLensImagesAnglesInProportion) {
  FisheyeLens lens;
  lens.centre = {200.0, 100.0};
  lens.focal_px = 60.0;
  const auto right = project(lens, at_angle(0.5, 0.0));
  ASSERT_TRUE(right);
  EXPECT_NEAR(right->u, 230.0, 1e-12);
  EXPECT_NEAR(right->v, 100.0, 1e-12);
  const auto up = project(lens, at_angle(0.5, kHalfPi));
  ASSERT_TRUE(up);
  EXPECT_NEAR(up->u, 200.0, 1e-12);
  EXPECT_NEAR(up->v, 70.0, 1e-12);  // v grows downwards
  EXPECT_NEAR(project(lens, {0, 0, 2})->u, 200.0, 0.0);
}

TEST(FisheyeLensTest, UnprojectInvertsProjectBeyond180Degrees) {
  std::mt19937_64 random(3);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int inverted = 0;
  for (int i = 0; i < 2000; ++i) {
    FisheyeLens lens;
    lens.centre = {uniform(0, 1000), uniform(0, 1000)};
    lens.focal_px = 50.0 * std::pow(40.0, uniform(0, 1));
    lens.k = {uniform(-0.03, 0.05), uniform(-0.004, 0.01), uniform(-0.001, 0.001),
              uniform(-1e-4, 1e-4)};
    lens.largest_angle_rad = radians_from_degrees(105.0);
    const Vector3d direction = at_angle(uniform(0, lens.largest_angle_rad), uniform(-kPi, kPi));
    const auto pixel = project(lens, direction);
    ASSERT_TRUE(pixel);
    const auto back = unproject(lens, *pixel);
    if (!back) continue;  // on the very rim
    EXPECT_LT((*back - direction).norm(), 1e-10);
    ++inverted;
  }
  EXPECT_GE(inverted, 1990);
}

TEST(FisheyeLensTest, RadiusIsWhereProjectPutsTheAngle) {
  FisheyeLens lens;
  lens.k = {0.02, -0.006, 0.001, -0.0001};
  for (double t = 0.1; t < lens.largest_angle_rad; t += 0.1) {
    const auto pixel = project(lens, at_angle(t, 0.0));
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->u, lens.focal_px * fisheye_radius(lens.k, t), 1e-12);
    // A wider floating-point type gives the same with more digits.
    EXPECT_NEAR(static_cast<double>(fisheye_radius(lens.k, static_cast<long double>(t))),
                fisheye_radius(lens.k, t), 1e-15);
  }
}

TEST(FisheyeLensTest, NothingIsSeenBeyondTheFieldOfView) {
  const FisheyeLens lens;
  EXPECT_TRUE(project(lens, at_angle(radians_from_degrees(94.9), 1.0)));
  EXPECT_FALSE(project(lens, at_angle(radians_from_degrees(95.1), 1.0)));
  const double rim = lens.focal_px * lens.largest_angle_rad;
  EXPECT_TRUE(unproject(lens, {rim - 0.01, 0}));
  EXPECT_FALSE(unproject(lens, {rim + 0.01, 0}));
}

}  // namespace
}  // namespace raywalk
