#include "simulator/room/cameras.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

TEST(DualFisheyeTest, BackLensLooksBackFromItsPosition) {
  DualFisheyeLayout layout = simple_dual_fisheye({400, 200});
  layout.back_position_m = {0, 0, -0.02};
  const DualFisheyeRays rays(layout, {400, 200});
  // Parts 7 and 8 of 16 are on either side of a pixel's centre; the image centre is between two
  // pixels.
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

TEST(DualFisheyeTest, NonMonotonicAndNonFiniteLensesAreRefused) {
  DualFisheyeLayout layout = simple_dual_fisheye({400, 200});
  layout.back.k = {-0.3, 0, 0, 0};
  EXPECT_THROW(DualFisheyeRays(layout, {400, 200}), Error);
  layout.back.k = {0, std::nan(""), 0, 0};
  EXPECT_THROW(DualFisheyeRays(layout, {400, 200}), Error);
}

}  // namespace
}  // namespace raywalk::capture
