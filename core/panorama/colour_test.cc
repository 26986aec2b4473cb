#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

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

TEST(GainFieldTest, ThePictureIsMultipliedAsAWhole) {
  cv::Mat colours = grey_panorama(64);
  apply_gains({.whole = {0.5F, 1.0F, 1.5F}}, &colours);
  EXPECT_EQ(cv::norm(colours, cv::Mat(64, 32, CV_8UC3, cv::Scalar(50, 100, 150)), cv::NORM_INF),
            0.0);
}

TEST(GainFieldTest, LocalFactorsHoldInTheMiddleOfTheirPatchAndAreLinearBetween) {
  for (const int width : {32, 100, 1024}) {
    GainField gains;
    gains.local = cv::Mat(4, 2, CV_32FC3, cv::Scalar(1, 1, 1));
    gains.local.row(1) = cv::Scalar(1.4, 1.4, 1.4);
    cv::Mat colours = grey_panorama(width);
    apply_gains(gains, &colours);
    const auto level = [&](double share) {
      return colours.at<cv::Vec3b>(static_cast<int>(share * width), width / 4)[0];
    };
    // Middles of the patches are at 1/8, 3/8, 5/8 and 7/8 of the panorama.
    const double tolerance = 100.0 * 0.4 * 4 / width + 1.0;
    EXPECT_NEAR(level(0.125), 100.0, tolerance) << width;
    EXPECT_NEAR(level(0.375), 140.0, tolerance) << width;
    EXPECT_NEAR(level(0.25), 120.0, tolerance) << width;
    EXPECT_NEAR(level(0.5), 120.0, tolerance) << width;
    EXPECT_NEAR(level(0.75), 100.0, tolerance) << width;
  }
}

TEST(GainFieldTest, TheSeamIsNoEdge) {
  GainField gains;
  gains.local = cv::Mat(4, 2, CV_32FC3, cv::Scalar(1, 1, 1));
  gains.local.row(3) = cv::Scalar(1.4, 1.4, 1.4);
  cv::Mat colours = grey_panorama(256);
  apply_gains(gains, &colours);
  EXPECT_NEAR(colours.at<cv::Vec3b>(0, 64)[0], 120, 1);
  EXPECT_NEAR(colours.at<cv::Vec3b>(255, 64)[0], 120, 1);
}

}  // namespace
}  // namespace raywalk
