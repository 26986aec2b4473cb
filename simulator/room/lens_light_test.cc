#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "simulator/room/sensor.h"

namespace raywalk::capture {
namespace {

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

TEST(LensLightTest, BackLensIsExposedByItsOwnGain) {
  const auto lenses = layout();
  const cv::Mat light = lens_light(lenses, kFrame, {0.0, -0.5});
  EXPECT_FLOAT_EQ(at_angle(light, lenses.front, 0.7), 1.0F);
  EXPECT_FLOAT_EQ(at_angle(light, lenses.back, 0.7), static_cast<float>(std::sqrt(0.5)));
}

TEST(LensLightTest, NonMonotonicLensIsRefused) {
  DualFisheyeLayout folded = layout();
  folded.back.k = {-0.3, 0, 0, 0};
  EXPECT_THROW(lens_light(folded, kFrame, {}), Error);
}

}  // namespace
}  // namespace raywalk::capture
