#include "core/geometry/spacing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

using Exact = boost::multiprecision::cpp_bin_float_100;

constexpr double kInfiniteDistance = std::numeric_limits<double>::infinity();
constexpr int kSpacingSamples = 3000;

// The two copies of a source by exact geometry: from the stations at -h and h, the directions to
// the source and to its assumed position, straight ahead of the middle.
Exact exact_ghost(double step_m, const Exact& inverse, const Exact& assumed_inverse) {
  const Exact h = Exact(step_m) / 2;
  const auto seen_aside = [&](const Exact& w) { return atan(Exact(h * w)); };
  return 2 * abs(Exact(seen_aside(inverse) - seen_aside(assumed_inverse)));
}

// The same in double precision, by the header's form without cancellation.
double ghost_angle(double step_m, double inverse, double assumed_inverse) {
  const double h = 0.5 * step_m;
  return 2.0 * std::atan2(h * std::abs(inverse - assumed_inverse),
                          1.0 + h * h * inverse * assumed_inverse);
}

class Spacing : public testing::Test {
 protected:
  double log_uniform(double low, double high) {
    std::uniform_real_distribution<double> exponent(std::log(low), std::log(high));
    return std::exp(exponent(random_));
  }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  bool one_in(int n) { return std::uniform_int_distribution<int>(1, n)(random_) == 1; }
  double inverse_distance() { return one_in(10) ? 0.0 : log_uniform(1e-12, 1e9); }
  double step() { return log_uniform(1e-9, 1e6); }

  std::mt19937_64 random_{7};
};

// The header's bounds for other directions and for other positions between the stations.
TEST_F(Spacing, OtherDirectionsAndPositionsAreHardlyWorse) {
  double most = 0.0;
  for (int i = 0; i < 20 * kSpacingSamples; ++i) {
    const double s = step();
    const double farthest_inverse = 1.0 / (1.2072 * s);  // tan 22.5 deg = 1 / (2 * 1.2071...)
    const double inverse = farthest_inverse * log_uniform(1e-6, 1.0);
    const double assumed = one_in(3) ? 0.0 : farthest_inverse * log_uniform(1e-6, 1.0);
    const auto gap = [&](double place, double psi) {
      const auto residual = [&](double t) {
        const auto turned = [&](double w) {
          return std::atan2(t * w * std::sin(psi), 1.0 - t * w * std::cos(psi));
        };
        return turned(inverse) - turned(assumed);
      };
      return std::abs(residual(place * s) - residual((place - 1.0) * s));
    };
    const double bound = ghost_angle(s, inverse, assumed);
    const double rounding = 1e-15;
    const double psi = uniform(1e-3, kPi - 1e-3);
    const double place = uniform(0.0, 1.0);  // of A, from one station to the other
    ASSERT_LE(gap(0.5, psi), bound * (1.0 + 1e-9) + rounding);
    ASSERT_LE(gap(place, kHalfPi), bound * (1.0 + 1e-9) + rounding);
    const double m = s * std::max(inverse, assumed);
    const double factor = (1.0 + 0.25 * m * m) / (1.0 - m * m);
    ASSERT_LE(gap(place, psi), bound * factor * (1.0 + 1e-9) + rounding);
    most = std::max(most, gap(0.5, psi) / bound);
  }
  EXPECT_GT(most, 0.99) << "the bound is not reached anywhere";
}

TEST_F(Spacing, SpacingNeededJustReachesTheToleranceAtAnyScale) {
  for (int i = 0; i < kSpacingSamples; ++i) {
    const double inverse = inverse_distance();
    // Half of the samples are so close that their difference has few significant digits.
    const double error = one_in(2) ? inverse_distance() : inverse * log_uniform(1e-15, 1e3);
    const double tolerance = one_in(4) ? uniform(0.1, 3.0) : log_uniform(1e-9, 0.1);
    const Exact assumed = Exact(inverse) + Exact(error);
    const double spacing = spacing_needed({inverse, inverse}, error, tolerance);
    if (std::isinf(spacing)) {
      // The ghost is largest at h^2 w w_0 = 1; even there it is within the tolerance.
      if (error == 0.0 || inverse == 0.0) continue;
      const double farthest = 2.0 / std::sqrt(inverse) / std::sqrt(inverse + error);
      ASSERT_LE(exact_ghost(farthest, inverse, assumed), tolerance * (1.0 + 1e-12));
      continue;
    }
    ASSERT_GT(spacing, 0.0);
    const Exact ghost = exact_ghost(spacing, inverse, assumed);
    ASSERT_NEAR(static_cast<double>(Exact(ghost / tolerance)), 1.0, 1e-12);
    ASSERT_LE(exact_ghost(spacing * (1.0 - 1e-6), inverse, assumed), tolerance);
  }
}

TEST_F(Spacing, SpacingNeededHoldsForEverySourceOfTheScene) {
  for (int i = 0; i < kSpacingSamples; ++i) {
    const double near = log_uniform(1e-2, 1e3);
    const InverseRange scene{one_in(3) ? 0.0 : uniform(0.0, 1.0) / near, 1.0 / near};
    const int layers = std::uniform_int_distribution<int>(1, 40)(random_);
    const double tolerance = log_uniform(1e-6, 0.05);
    const double error = inverse_error_of_layers(scene, layers);
    const double spacing = spacing_needed(scene, error, tolerance);
    if (std::isinf(spacing)) continue;
    for (int source = 0; source < 20; ++source) {
      const double inverse = uniform(scene.min, scene.max);
      const double width = 2.0 * error;
      const double layer = std::min(std::floor((inverse - scene.min) / width), layers - 1.0);
      const double assumed = scene.min + (layer + 0.5) * width;
      ASSERT_LE(ghost_angle(spacing, inverse, assumed), tolerance * (1.0 + 1e-9));
    }
    const double in_place = spacing_needed_without_depth(scene, tolerance);
    EXPECT_NEAR(largest_ghost_without_depth(scene, in_place), tolerance, 1e-12 * tolerance);
    ASSERT_LE(ghost_angle(in_place, uniform(scene.min, scene.max), 0.0), tolerance * (1.0 + 1e-12));
    EXPECT_NEAR(nearest_distance_resolved(in_place, tolerance) * scene.max, 1.0, 1e-12);
  }
}

TEST_F(Spacing, DepthAllowsWiderSpacing) {
  const InverseRange scene{0.2, 1.0};
  const double tolerance = angle_of_pixels(0.5, 1024);
  const double in_place = spacing_needed_without_depth(scene, tolerance);
  double last = in_place;
  for (const int layers : {1, 2, 4, 8}) {
    const double spacing = spacing_needed(scene, inverse_error_of_layers(scene, layers), tolerance);
    EXPECT_GT(spacing, 1.9 * last);
    last = spacing;
  }
}

TEST_F(Spacing, SceneAtInfinityNeedsNoStations) {
  EXPECT_EQ(spacing_needed_without_depth({0.0, 0.0}, 1e-3), kInfiniteDistance);
  EXPECT_EQ(spacing_needed({0.5, 0.5}, 0.0, 1e-3), kInfiniteDistance);
  EXPECT_EQ(largest_ghost_without_depth({0.0, 0.0}, 10.0), 0.0);
  EXPECT_EQ(nearest_distance_resolved(0.0, 1e-3), 0.0);
}

TEST_F(Spacing, PixelsAreAngles) {
  EXPECT_DOUBLE_EQ(angle_of_pixels(1024.0, 1024), kTwoPi);
  EXPECT_DOUBLE_EQ(angle_of_pixels(0.5, 360), radians_from_degrees(0.5));
}

// Inverse distance of the layer nearest to `w`.
double layer_of(double inverse, InverseRange range, int count) {
  const double step = (range.max - range.min) / count;
  const double index = std::clamp(std::floor((inverse - range.min) / step), 0.0, count - 1.0);
  return range.min + (index + 0.5) * step;
}

TEST(LayerCount, CountKeepsEveryPixelWithinTheTolerance) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double most_q = std::sin(radians_from_degrees(80.0));
  double worst = 0.0;
  for (int scene = 0; scene < 200; ++scene) {
    const double nearest_m = std::pow(10.0, 3.0 * unit(random) - 1.0);
    const InverseRange range{unit(random) / nearest_m, 1.0 / nearest_m};
    const double d_p = nearest_m * std::pow(10.0, 3.0 * unit(random) - 2.0);
    const double tolerance = std::pow(10.0, -3.0 - 0.3 * unit(random));
    const int count = layers_for_tolerance(range, d_p, tolerance);
    ASSERT_LT(count, 65536);
    for (int i = 0; i < 500; ++i) {
      const double phi = kPi * (unit(random) - 0.5);
      const double inverse = range.min + (range.max - range.min) * unit(random);
      const double snapped = layer_of(inverse, range, count);
      const double q = d_p * inverse * std::sin(phi);
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
