#include "build_lf/refine/directional_mean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

namespace raywalk::build_lf {
namespace {

// The mean of `count` samples around `angle_rad`, of colours that `colour` gives for an angle.
template <typename Colour>
cv::Vec3f mean_of(int count, const Colour& colour) {
  DirectionalMean mean;
  for (int i = 0; i < count; ++i) {
    const float angle = 0.5f * static_cast<float>(i) / static_cast<float>(count);
    mean.add(colour(angle), 1.0f / (angle + 0.02f), angle);
  }
  return mean.value();
}

TEST(DirectionalMeanTest, AveragesTheNoiseOfAMattSurfaceOverAllDirections) {
  double squared = 0.0;
  constexpr int kTrials = 500;
  for (int trial = 0; trial < kTrials; ++trial) {
    cv::RNG random(static_cast<std::uint64_t>(trial + 1));
    const cv::Vec3f mean = mean_of(40, [&](float) {
      return cv::Vec3f::all(100.0f + static_cast<float>(random.gaussian(6.0)));
    });
    squared += std::pow(mean[1] - 100.0, 2) / kTrials;
  }
  // Of equal weights 6 / sqrt(40) = 0.95; near ones count more.
  EXPECT_LT(std::sqrt(squared), 1.8);
}

TEST(DirectionalMeanTest, ShowsAMirrorAsItIsInTheDirection) {
  const cv::Vec3f mean =
      mean_of(40, [](float angle) { return cv::Vec3f::all(angle < 0.06f ? 200.0f : 60.0f); });
  EXPECT_NEAR(mean[0], 200.0f, 1.0f);
}

TEST(DirectionalMeanTest, AFewSamplesFarAsideAreBetterThanNone) {
  DirectionalMean mean;
  EXPECT_TRUE(mean.empty());
  mean.add({10.0f, 20.0f, 30.0f}, 1e-6f, 3.0f);
  EXPECT_FALSE(mean.empty());
  EXPECT_NEAR(cv::norm(mean.value() - cv::Vec3f(10.0f, 20.0f, 30.0f)), 0.0, 1e-3);
}

TEST(DirectionalMeanTest, StaysWithinItsSamplesAtTheExtremes) {
  for (const float weight : {1e-20f, 1.0f, 1e20f}) {
    for (const float level : {0.0f, 255.0f}) {
      DirectionalMean mean;
      for (int i = 0; i < 50; ++i) {
        mean.add(cv::Vec3f::all(level), weight, static_cast<float>(i) * 0.06f);
      }
      EXPECT_NEAR(mean.value()[2], level, 1e-3) << weight;
    }
  }
}

}  // namespace
}  // namespace raywalk::build_lf
