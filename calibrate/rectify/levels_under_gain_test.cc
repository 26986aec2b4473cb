#include "calibrate/rectify/levels_under_gain.h"

#include <gtest/gtest.h>

#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

TEST(LevelsUnderGainTest, LightIsMultiplied) {
  const LevelsUnderGain levels(LightGain{1.7, 1.0, 0.5});
  for (float level = 0.0f; level <= 255.0f; level += 0.37f) {
    const cv::Vec3f changed = levels({level, level, level});
    EXPECT_NEAR(changed[0], srgb_level_from_linear(0.5 * linear_from_srgb_level(level)), 0.01);
    EXPECT_NEAR(changed[1], level, 0.001);
    EXPECT_NEAR(changed[2], srgb_level_from_linear(1.7 * linear_from_srgb_level(level)), 0.01);
  }
}

TEST(LevelsUnderGainTest, OvershootOfCubicsIsClamped) {
  const LevelsUnderGain levels(LightGain{1.0, 1.0, 1.0});
  const cv::Vec3f changed = levels({-20.0f, 300.0f, 255.0f});
  EXPECT_NEAR(changed[0], 0.0, 0.001);
  EXPECT_NEAR(changed[1], 255.0, 0.001);
  EXPECT_NEAR(changed[2], 255.0, 0.001);
}

}  // namespace
}  // namespace raywalk::calibrate
