#include "calibrate/stitch/balance_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/geometry/sphere.h"

namespace raywalk::calibrate {
namespace {

const LensBalance kTruth{{1.10, 1.05, 0.92}, -0.04, -0.02};

class Scene {
 public:
  explicit Scene(unsigned seed) : random_(seed) {}

  double uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }

  LightRatio ratio(LensPlace first, LensPlace second, double log_exposure, double noise) {
    LightRatio ratio{first, second, {}, std::nullopt};
    for (std::size_t colour = 0; colour < 3; ++colour) {
      ratio.log_light[colour] = log_light(second, colour) - log_light(first, colour) +
                                log_exposure + std::normal_distribution<double>(0, noise)(random_);
    }
    return ratio;
  }

  // Both lenses see up to 97 degrees from their axes.
  std::vector<LightRatio> overlap(int count, double noise) {
    std::vector<LightRatio> ratios;
    for (int i = 0; i < count; ++i) {
      const double angle = radians_from_degrees(uniform(84.0, 96.0));
      ratios.push_back(ratio({false, angle}, {true, kPi - angle}, 0.0, noise));
    }
    return ratios;
  }

  // Every pair of frames has its own exposure ratio.
  std::vector<LightRatio> motion(int count, double noise) {
    std::vector<LightRatio> ratios;
    for (int i = 0; i < count; ++i) {
      const bool back = i % 2 == 0;
      const double angle = uniform(0.0, 1.5);
      ratios.push_back(
          ratio({back, angle}, {back, angle + uniform(-0.15, 0.15)}, 0.1 * (i % 5) - 0.2, noise));
      ratios.back().frames = i % 5;
    }
    return ratios;
  }

 private:
  static double log_light(LensPlace place, std::size_t colour) {
    return std::log(kTruth.share_at(place.angle_rad)) +
           (place.back ? std::log(kTruth.back_gain[colour]) : 0.0);
  }

  std::mt19937 random_;
};

std::vector<LightRatio> joined(std::vector<LightRatio> a, const std::vector<LightRatio>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

double log_share_error(const LensBalance& balance, double angle_deg) {
  const double angle = radians_from_degrees(angle_deg);
  return std::log(balance.share_at(angle) / kTruth.share_at(angle));
}

TEST(BalanceFitTest, RecoversGainsAndFalloffWithinItsSigmas) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    Scene scene(seed);
    const BalanceFit fit = fit_balance(joined(scene.overlap(1000, 0.02), scene.motion(2000, 0.02)));
    for (std::size_t c = 0; c < 3; ++c) {
      const double error = std::log(fit.balance.back_gain[c] / kTruth.back_gain[c]);
      EXPECT_LT(std::abs(error), 4.0 * fit.gain_sigma);
    }
    EXPECT_LT(std::abs(log_share_error(fit.balance, 45.0)), 4.0 * fit.share_45_sigma);
    EXPECT_LT(std::abs(log_share_error(fit.balance, 90.0)), 4.0 * fit.share_90_sigma);
    EXPECT_LT(fit.share_90_sigma, 0.02);
    EXPECT_NEAR(fit.scatter, 0.02, 0.002);
  }
}

TEST(BalanceFitTest, IsRobustToAThirdOfOutliers) {
  Scene scene(1);
  auto ratios = joined(scene.overlap(1000, 0.02), scene.motion(2000, 0.02));
  for (std::size_t i = 0; i < ratios.size(); i += 3) {
    for (double& log_light : ratios[i].log_light) log_light += scene.uniform(-1.0, 2.0);
  }
  const BalanceFit fit = fit_balance(ratios);
  EXPECT_NEAR(fit.balance.back_gain[0], kTruth.back_gain[0], 0.01);
  EXPECT_NEAR(log_share_error(fit.balance, 90.0), 0.0, 0.03);
}

// The overlap determines only the slope of the falloff at the rim, and the sigmas show it.
TEST(BalanceFitTest, OverlapAloneDoesNotDetermineTheFalloff) {
  Scene scene(2);
  const BalanceFit fit = fit_balance(scene.overlap(3000, 0.02));
  EXPECT_NEAR(fit.balance.back_gain[1], kTruth.back_gain[1], 0.005);
  const auto slope = [](const LensBalance& balance) {
    return std::log(balance.share_at(1.58) / balance.share_at(1.56)) / 0.02;
  };
  EXPECT_NEAR(slope(fit.balance), slope(kTruth), 0.05);
  EXPECT_GT(fit.share_90_sigma, 0.1);
  EXPECT_LT(std::abs(log_share_error(fit.balance, 90.0)), 3.0 * fit.share_90_sigma);
}

TEST(BalanceFitTest, IsTheIdentityWithoutRatios) {
  const BalanceFit fit = fit_balance({});
  EXPECT_EQ(fit.balance.back_gain[0], 1.0);
  EXPECT_EQ(fit.balance.share_at(1.5), 1.0);
  EXPECT_GT(fit.gain_sigma, 0.5);
}

}  // namespace
}  // namespace raywalk::calibrate
