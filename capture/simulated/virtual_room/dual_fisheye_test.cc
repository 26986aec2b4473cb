#include "capture/simulated/virtual_room/dual_fisheye.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/simulated/virtual_room/hash_random.h"
#include "core/base/error.h"

namespace raywalk {
namespace {

using Eigen::Vector3d;

Vector3d at_angle(double off_axis_rad, double around_rad) {
  return {std::sin(off_axis_rad) * std::cos(around_rad),
          std::sin(off_axis_rad) * std::sin(around_rad), std::cos(off_axis_rad)};
}

TEST(DualFisheyeTest, EquidistantLensImagesAnglesInProportion) {
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

TEST(DualFisheyeTest, UnprojectInvertsProjectBeyond180Degrees) {
  HashRandom random(3);
  int inverted = 0;
  for (int i = 0; i < 2000; ++i) {
    FisheyeLens lens;
    lens.centre = {random.uniform(0, 1000), random.uniform(0, 1000)};
    lens.focal_px = 50.0 * std::pow(40.0, random.uniform());
    lens.k = {random.uniform(-0.03, 0.05), random.uniform(-0.004, 0.01),
              random.uniform(-0.001, 0.001), random.uniform(-1e-4, 1e-4)};
    lens.largest_angle_rad = radians_from_degrees(105.0);
    const Vector3d direction =
        at_angle(random.uniform(0, lens.largest_angle_rad), random.uniform(-kPi, kPi));
    const auto pixel = project(lens, direction);
    ASSERT_TRUE(pixel);
    const auto back = unproject(lens, *pixel);
    if (!back) continue;  // on the very rim
    EXPECT_LT((*back - direction).norm(), 1e-10);
    ++inverted;
  }
  EXPECT_GE(inverted, 1990);
}

TEST(DualFisheyeTest, NothingIsSeenBeyondTheFieldOfView) {
  const FisheyeLens lens;
  EXPECT_TRUE(project(lens, at_angle(radians_from_degrees(94.9), 1.0)));
  EXPECT_FALSE(project(lens, at_angle(radians_from_degrees(95.1), 1.0)));
  const double rim = lens.focal_px * lens.largest_angle_rad;
  EXPECT_TRUE(unproject(lens, {rim - 0.01, 0}));
  EXPECT_FALSE(unproject(lens, {rim + 0.01, 0}));
}

TEST(DualFisheyeTest, BackLensLooksBackFromWhereItIs) {
  DualFisheyeLayout layout = simple_dual_fisheye({400, 200});
  layout.back_position_m = {0, 0, -0.02};
  const DualFisheyeRays rays(layout, {400, 200});
  // Parts 7 and 8 of 16 lie on either side of a pixel's centre, and the image's middle lies between
  // two pixels.
  const auto front = rays.at_part(100 * kPixelParts, 100 * kPixelParts);
  const auto back = rays.at_part(300 * kPixelParts, 100 * kPixelParts);
  ASSERT_TRUE(front && back);
  EXPECT_GT(front->direction.z(), 0.9999);
  EXPECT_LT(back->direction.z(), -0.9999);
  EXPECT_EQ(front->origin_m, Vector3d(0, 0, 0));
  EXPECT_EQ(back->origin_m, Vector3d(0, 0, -0.02));
  // To the right in the back lens's image is the camera's left.
  EXPECT_LT(rays.at_part(350 * kPixelParts, 100 * kPixelParts)->direction.x(), -0.5);
  EXPECT_FALSE(rays.at_part(0, 0));
}

TEST(DualFisheyeTest, LensThatFoldsOrIsNoNumberIsRefused) {
  DualFisheyeLayout layout = simple_dual_fisheye({400, 200});
  layout.back.k = {-0.3, 0, 0, 0};
  EXPECT_THROW(DualFisheyeRays(layout, {400, 200}), Error);
  layout.back.k = {0, std::nan(""), 0, 0};
  EXPECT_THROW(DualFisheyeRays(layout, {400, 200}), Error);
}

}  // namespace
}  // namespace raywalk
