#include "core/geometry/layer_count.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

// Inverse distance of the layer nearest to `omega`.
double layer_of(double omega, OmegaRange range, int count) {
  const double step = (range.max - range.min) / count;
  const double index = std::clamp(std::floor((omega - range.min) / step), 0.0, count - 1.0);
  return range.min + (index + 0.5) * step;
}

TEST(LayerCount, CountKeepsEveryPixelWithinTheTolerance) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double most_q = std::sin(radians_from_degrees(80.0));
  double worst = 0.0;
  for (int scene = 0; scene < 200; ++scene) {
    const double nearest_m = std::pow(10.0, 3.0 * unit(random) - 1.0);
    const OmegaRange range{unit(random) / nearest_m, 1.0 / nearest_m};
    const double d_p = nearest_m * std::pow(10.0, 3.0 * unit(random) - 2.0);
    const double tolerance = std::pow(10.0, -3.0 - 0.3 * unit(random));
    const int count = layers_for_tolerance(range, d_p, tolerance);
    ASSERT_LT(count, 65536);
    for (int i = 0; i < 500; ++i) {
      const double phi = kPi * (unit(random) - 0.5);
      const double omega = range.min + (range.max - range.min) * unit(random);
      const double snapped = layer_of(omega, range, count);
      const double q = d_p * omega * std::sin(phi);
      const double snapped_q = d_p * snapped * std::sin(phi);
      if (std::max(std::fabs(q), std::fabs(snapped_q)) > most_q) continue;
      // alpha = phi* + asin(q): the latitude read, with and without layers.
      const double moved = std::fabs(std::asin(snapped_q) - std::asin(q));
      ASSERT_LE(moved, tolerance * (1.0 + 1e-9));
      worst = std::max(worst, moved / tolerance);
    }
  }
  EXPECT_GT(worst, 0.9) << "far more layers than the tolerance needs";
}

TEST(LayerCount, CountGrowsWithRangeDistanceAndPrecision) {
  const OmegaRange range{0.1, 1.0};
  const int count = layers_for_tolerance(range, 0.5, 1e-3);
  EXPECT_GT(count, 1);
  EXPECT_GT(layers_for_tolerance({0.1, 1.2}, 0.5, 1e-3), count);
  EXPECT_GT(layers_for_tolerance(range, 0.7, 1e-3), count);
  EXPECT_GT(layers_for_tolerance(range, 0.5, 0.5e-3), count);
}

TEST(LayerCount, NoCorrectionNeedsOneLayer) {
  EXPECT_EQ(layers_for_tolerance({0.5, 0.5}, 1.0, 1e-3), 1);
  EXPECT_EQ(layers_for_tolerance({0.1, 2.0}, 0.0, 1e-3), 1);
  EXPECT_EQ(layers_for_tolerance({0.0, 0.0}, 1.0, 1e-3), 1);
}

TEST(LayerCount, CountIsBoundedForScenesThatTouchTheLine) {
  EXPECT_EQ(layers_for_tolerance({0.0, 1e12}, 1.0, 1e-4), 65536);
  EXPECT_EQ(layers_for_tolerance({0.0, 1.0}, 1e300, 1e-300), 65536);
}

}  // namespace
}  // namespace raywalk
