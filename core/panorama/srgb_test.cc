#include "core/panorama/srgb.h"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace raywalk
