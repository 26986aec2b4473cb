#include "simulator/room/sensor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/panorama/srgb.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::simulator {
namespace {

cv::Mat grey(int level) { return cv::Mat(200, 300, CV_8UC3, cv::Scalar::all(level)); }

struct Statistics {
  double mean;
  double deviation;
};

Statistics statistics_of(const cv::Mat& image) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(image.reshape(1), mean, deviation);
  return {mean[0], deviation[0]};
}

// Rounding to whole levels adds a variance of 1/12.
double with_rounding(double variance) { return std::sqrt(variance + 1.0 / 12.0); }

TEST(SensorTest, PerfectSensorChangesNothing) {
  cv::Mat ramp(1, 256, CV_8UC3);
  for (int i = 0; i < 256; ++i) ramp.at<cv::Vec3b>(0, i) = cv::Vec3b::all(static_cast<uchar>(i));
  const cv::Mat out = apply_sensor(ramp, {}, 1.0, 1);
  EXPECT_TRUE(std::equal(ramp.datastart, ramp.dataend, out.datastart));
}

// The standard error of the mean of 180,000 values is 0.24 % of their deviation, that of the
// deviation 0.17 %.
TEST(SensorTest, NoiseHasTheGivenMeanAndDeviation) {
  for (const double levels : {1.0, 3.0, 8.0}) {
    SensorSettings sensor;
    sensor.noise_levels = levels;
    const Statistics found = statistics_of(apply_sensor(grey(120), sensor, 1.0, 5));
    EXPECT_NEAR(found.mean, 120.0, 0.012 * levels);
    EXPECT_NEAR(found.deviation, with_rounding(levels * levels), 0.01 * levels);
  }
}

TEST(SensorTest, ShotNoiseGrowsWithTheSquareRootOfBrightness) {
  SensorSettings sensor;
  sensor.noise_levels = 1.0;
  sensor.shot_noise = 0.2;
  for (const int level : {40, 160}) {
    const double expected = with_rounding(1.0 + 0.2 * level);
    EXPECT_NEAR(statistics_of(apply_sensor(grey(level), sensor, 1.0, 6)).deviation, expected,
                0.01 * expected);
  }
}

TEST(SensorTest, ChannelsAndNeighboursAreIndependent) {
  SensorSettings sensor;
  sensor.noise_levels = 6.0;
  cv::Mat noise;
  apply_sensor(grey(128), sensor, 1.0, 7).convertTo(noise, CV_32F);
  noise -= cv::Scalar::all(128.0);
  const cv::Mat values = noise.reshape(1);
  const double variance = values.dot(values) / static_cast<double>(values.total());
  for (const int step : {1, 2, 3, 6}) {  // within a pixel, across channels, neighbouring pixels
    const cv::Mat a = values.colRange(0, values.cols - step);
    const cv::Mat b = values.colRange(step, values.cols);
    EXPECT_NEAR(a.dot(b) / static_cast<double>(a.total()) / variance, 0.0, 0.015) << step;
  }
}

TEST(SensorTest, LightOfEachPixelMultipliesItsGain) {
  cv::Mat light(200, 300, CV_32FC1, cv::Scalar::all(0.5));
  light.colRange(150, 300).setTo(1.0);
  const cv::Mat out = apply_sensor(grey(200), {}, 0.8, 1, light);
  const double half = srgb_level_from_linear(0.4 * linear_from_srgb_level(200));
  const double whole = srgb_level_from_linear(0.8 * linear_from_srgb_level(200));
  EXPECT_NEAR(statistics_of(out.colRange(0, 150)).mean, half, 0.5);
  EXPECT_NEAR(statistics_of(out.colRange(150, 300)).mean, whole, 0.5);
  EXPECT_THROW(apply_sensor(grey(200), {}, 1.0, 1, light.rowRange(0, 100)), Error);
}

// Else the same noise in every frame would look like texture of the scene.
TEST(SensorTest, KeyChoosesTheNoise) {
  SensorSettings sensor;
  sensor.noise_levels = 4.0;
  const cv::Mat first = apply_sensor(grey(90), sensor, 1.0, 1);
  EXPECT_EQ(cv::norm(first, apply_sensor(grey(90), sensor, 1.0, 1), cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(first, apply_sensor(grey(90), sensor, 1.0, 2), cv::NORM_L2) /
                std::sqrt(first.total() * 3.0),
            4.0);
}

TEST(SensorTest, GainMultipliesLightAndClipsAtWhite) {
  for (const int level : {20, 100, 150}) {
    const double out = statistics_of(apply_sensor(grey(level), {}, 1.5, 1)).mean;
    const double expected = srgb_level_from_linear(1.5 * linear_from_srgb_level(level));
    EXPECT_NEAR(out, expected, 0.5);
  }
  EXPECT_EQ(statistics_of(apply_sensor(grey(240), {}, 2.0, 1)).mean, 255.0);
}

TEST(SensorTest, RefusesOtherImagesAndGains) {
  EXPECT_THROW(apply_sensor(cv::Mat(4, 4, CV_8UC1), {}, 1.0, 1), Error);
  EXPECT_THROW(apply_sensor(grey(1), {}, 0.0, 1), Error);
  EXPECT_THROW(apply_sensor(grey(1), {}, std::nan(""), 1), Error);
}

TEST(ToneTest, CurveRisesAndBendsAtHighlights) {
  EXPECT_EQ(level_from_light(-1.0F), 0.0F);
  EXPECT_NEAR(level_from_light(0.5F), 187.5F, 0.1F);  // sRGB's level of a half
  for (int i = 1; i <= 400; ++i) {
    EXPECT_GE(level_from_light(0.01F * static_cast<float>(i)),
              level_from_light(0.01F * static_cast<float>(i - 1)));
  }
  EXPECT_LT(level_from_light(1.0F), 250.0F);
  EXPECT_NEAR(level_from_light(100.0F), 255.0F, 0.5F);
}

constexpr PanoramaSize kFrame{404, 202};

// Both lenses' axes go through the centre of a pixel.
DualFisheyeLayout layout() {
  DualFisheyeLayout layout = simple_dual_fisheye(kFrame);
  layout.front.centre = {100.0, 100.0};
  layout.back.centre = {302.0, 100.0};
  return layout;
}

float at_angle(const cv::Mat& light, const FisheyeLens& lens, double share_of_rim) {
  const double t = share_of_rim * lens.largest_angle_rad;
  const PixelPosition pixel = *project(lens, {std::sin(t), 0.0, std::cos(t)});
  return light.at<float>(cvRound(pixel.v), cvRound(pixel.u));
}

TEST(LensLightTest, VignettingIncreasesTowardsTheRim) {
  const auto lenses = layout();
  const cv::Mat light = lens_light(lenses, kFrame, {0.4, 0.0});
  for (const FisheyeLens& lens : {lenses.front, lenses.back}) {
    EXPECT_FLOAT_EQ(at_angle(light, lens, 0.0), 1.0F);
    EXPECT_NEAR(at_angle(light, lens, 0.5), 1.0 - 0.4 * 0.5 * (0.25 + 0.0625), 0.004);
    EXPECT_NEAR(at_angle(light, lens, 0.99), 0.6, 0.02);
    for (int tenths = 1; tenths < 10; ++tenths) {
      EXPECT_LT(at_angle(light, lens, 0.1 * tenths), at_angle(light, lens, 0.1 * (tenths - 1)));
    }
  }
  EXPECT_EQ(light.at<float>(0, 0), 1.0F);
}

}  // namespace
}  // namespace raywalk::simulator
