#include "calibrate/rectify/exposure_gains.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

// Two lines of ten frames that cross once; every channel has its own gains.
class SolveGainsTest : public ::testing::Test {
 protected:
  SolveGainsTest() {
    std::mt19937 random(7);
    std::normal_distribution<double> drift(0.0, 0.05);
    for (LightGain& gain : truth_) {
      for (double& factor : gain) factor = std::exp(drift(random));
    }
    for (int line = 0; line < 2; ++line) {
      for (int i = 0; i + 1 < 10; ++i) add({10 * line + i, 10 * line + i + 1}, random);
    }
    for (const int i : {4, 5}) {
      for (const int j : {14, 15}) add({i, j}, random);
    }
  }
  void add(FrameLink link, std::mt19937& random) {
    std::normal_distribution<double> noise(0.0, 0.002);
    ComparedLink compared{
        .link = link, .colours = {.comparable = true, .log_ratio_error = {0.002, 0.002, 0.002}}};
    for (std::size_t c = 0; c < 3; ++c) {
      compared.colours.log_ratio[c] = std::log(truth_[static_cast<std::size_t>(link.from)][c] /
                                               truth_[static_cast<std::size_t>(link.to)][c]) +
                                      noise(random);
    }
    links_.push_back(compared);
  }
  // The largest error of a logarithm of a gain, up to a factor common to all frames.
  double worst_error(const std::vector<LightGain>& gains) const {
    double worst = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      double mean = 0.0;
      for (std::size_t i = 0; i < 20; ++i) mean += std::log(gains[i][c] / truth_[i][c]) / 20.0;
      for (std::size_t i = 0; i < 20; ++i) {
        worst = std::max(worst, std::abs(std::log(gains[i][c] / truth_[i][c]) - mean));
      }
    }
    return worst;
  }

  std::vector<LightGain> truth_ = std::vector<LightGain>(22);
  std::vector<ComparedLink> links_{};
};

TEST_F(SolveGainsTest, GainsAreRecoveredUpToACommonFactor) {
  const std::vector<LightGain> gains = solve_gains(20, links_);
  // Along ten links of 0.002 the error grows to about 0.006.
  EXPECT_LT(worst_error(gains), 0.015);
  for (std::size_t c = 0; c < 3; ++c) {
    double mean = 0.0;
    for (const LightGain& gain : gains) mean += std::log(gain[c]) / 20.0;
    EXPECT_NEAR(mean, 0.0, 1e-9);
  }
}

TEST_F(SolveGainsTest, IsRobustToAWrongLink) {
  links_[18].colours.log_ratio = {1.0, 1.0, 1.0};  // a link at the crossing
  EXPECT_LT(worst_error(solve_gains(20, links_)), 0.015);
}

TEST_F(SolveGainsTest, UnlinkedFramesHaveUnitGain) {
  links_.push_back({.link = {20, 21}, .colours = {.log_ratio = {1.0, 1.0, 1.0}}});
  const std::vector<LightGain> gains = solve_gains(22, links_);
  EXPECT_EQ(gains[20], (LightGain{1.0, 1.0, 1.0}));
  EXPECT_EQ(gains[21], (LightGain{1.0, 1.0, 1.0}));
}

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
