// Errors of views in closed form, and the spacing and the layers that keep them small.
#include "core/geometry/error_model.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/geometry/spacing.h"
#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

// The equations as printed lose up to 34 digits over the tested domain (step^2 / d_src^2 in (3)),
// so 100 digits are more than enough.
using Exact = boost::multiprecision::cpp_bin_float_100;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kSamples = 3000;
constexpr double kBoundUlp = 4.0;

Exact exact_pi() { return boost::math::constants::pi<Exact>(); }

// The equations as printed in the paper.
Exact printed_2(double d, double phi, double apart) {
  const Exact p = phi;
  return atan2(Exact(d * sin(p)), Exact(d * cos(p))) -
         atan2(Exact(d * sin(p)), Exact(d * cos(p) + apart));
}

Exact printed_3(double d, double phi, double theta, double step) {
  const Exact c = d * cos(Exact(phi));
  const Exact t = theta;
  const Exact ahead = c * cos(t);
  const Exact aside = c * sin(t) + step;
  return sqrt(Exact(ahead * ahead + aside * aside)) - c;
}

Exact tan_deg(double k_deg) { return tan(Exact(Exact(k_deg) * exact_pi() / 180)); }

Exact printed_8(double a, double b, double k_deg) {
  return (a - b * tan_deg(k_deg)) / cos(Exact((90 - Exact(k_deg)) * exact_pi() / 180));
}

// The distance of a result from the exact value in units of its last place.
double error_ulp(double actual, const Exact& exact) {
  const double rounded = std::abs(static_cast<double>(exact));
  const double ulp = std::nextafter(rounded, kInfinity) - rounded;
  return static_cast<double>(Exact(abs(Exact(actual - exact)) / ulp));
}

class Numerics : public testing::Test {
 protected:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double log_uniform(double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  }
  double step() { return log_uniform(1e-9, 1e6); }
  bool one_in(int n) { return std::uniform_int_distribution<int>(1, n)(random_) == 1; }

  std::mt19937_64 random_{20230101};
};

class ErrorModelNumerics : public Numerics {
 protected:
  double distance() { return log_uniform(1e-6, 1e8); }

  // Latitudes at the poles, beside them, near the horizon and anywhere between; either sign.
  double latitude() {
    const double sign = one_in(2) ? -1.0 : 1.0;
    if (one_in(8)) return sign * kHalfPi;
    if (one_in(4)) return sign * (kHalfPi - log_uniform(1e-15, 1.0));
    if (one_in(2)) return sign * log_uniform(1e-12, kHalfPi);
    return uniform(-kHalfPi, kHalfPi);
  }
  // Incidence angles on the side that turns away, its ends included.
  double incidence() { return std::abs(latitude()); }

  // A corner whose angle is anywhere in [45, 90] degrees, both ends included.
  CornerOffset corner() {
    const double side = distance();
    if (one_in(8)) return {side, 0.0};
    if (one_in(8)) return {side, side};
    return {side, side * log_uniform(1e-12, 1.0)};
  }
  // A limit angle at the ends of the range, beside 90 degrees, or anywhere between.
  double limit_deg() {
    if (one_in(6)) return 45.0;
    if (one_in(6)) return 90.0;
    if (one_in(3)) return 90.0 - log_uniform(1e-13, 45.0);
    return uniform(45.0, 90.0);
  }
};

TEST_F(ErrorModelNumerics, LatitudeShiftIsExactToFourUlp) {
  for (int i = 0; i < kSamples; ++i) {
    const double d = distance(), phi = latitude(), apart = step();
    EXPECT_LE(error_ulp(latitude_shift(d, phi, apart), printed_2(d, phi, apart)), kBoundUlp)
        << "d " << d << " phi " << phi << " apart " << apart;
  }
}

TEST_F(ErrorModelNumerics, LatitudeShiftIsOddBoundedAndMonotone) {
  for (int i = 0; i < 100000; ++i) {
    const double d = distance(), phi = latitude(), apart = step();
    const double shift = latitude_shift(d, phi, apart);
    EXPECT_EQ(latitude_shift(d, -phi, apart), -shift);
    EXPECT_LE(std::abs(shift), std::abs(phi));
    EXPECT_EQ(std::signbit(shift), std::signbit(phi));
    EXPECT_LE(std::abs(latitude_shift(d * (1.0 + log_uniform(1e-12, 1e3)), phi, apart)),
              std::abs(shift));
    EXPECT_GE(std::abs(latitude_shift(d, phi, apart * (1.0 + log_uniform(1e-12, 1e3)))),
              std::abs(shift));
  }
}

TEST_F(ErrorModelNumerics, LatitudeShiftHasItsLimits) {
  for (int i = 0; i < 1000; ++i) {
    const double phi = latitude();
    EXPECT_EQ(latitude_shift(kInfinity, phi, step()), 0.0);
    EXPECT_EQ(latitude_shift(kInfinity, phi, kInfinity), 0.0);
    EXPECT_EQ(latitude_shift(distance(), phi, 0.0), 0.0);
    EXPECT_EQ(latitude_shift(0.0, phi, 0.0), 0.0);
    EXPECT_EQ(latitude_shift(distance(), 0.0, step()), 0.0);
    EXPECT_DOUBLE_EQ(latitude_shift(0.0, phi, step()), phi);
    EXPECT_DOUBLE_EQ(latitude_shift(distance(), phi, kInfinity), phi);
  }
}

TEST_F(ErrorModelNumerics, LatitudeShiftHoldsAtTheEdgeOfDouble) {
  // The products D sin(phi) and D cos(phi) would underflow or overflow here.
  for (const double phi : {1e-300, 1e-160, 1.0, kHalfPi}) {
    for (const double d : {1e-300, 1e-150, 1e150, 1e300}) {
      const double shift = latitude_shift(d, phi, d * 0.5);
      EXPECT_LE(error_ulp(shift, printed_2(d, phi, d * 0.5)), kBoundUlp) << phi << " " << d;
    }
  }
}

TEST_F(ErrorModelNumerics, BendingDistanceIsExactToFourUlp) {
  for (int i = 0; i < kSamples; ++i) {
    const double d = distance(), phi = latitude(), theta = incidence(), s = step();
    EXPECT_LE(error_ulp(bending_distance(d, phi, theta, s), printed_3(d, phi, theta, s)), kBoundUlp)
        << "d " << d << " phi " << phi << " theta " << theta << " step " << s;
  }
}

TEST_F(ErrorModelNumerics, BendingDistanceKeepsItsBoundWhereItCrossesZero) {
  for (int i = 0; i < kSamples; ++i) {
    const double d = distance(), phi = 0.9 * latitude(), theta = -incidence();
    const double twice_aside = 2.0 * d * std::cos(phi) * std::abs(std::sin(theta));
    // Half of the samples are beside the zero.
    const double s = one_in(2) ? step() : twice_aside * (1.0 + log_uniform(1e-12, 1e-1));
    const Exact aside = 2 * d * cos(Exact(phi)) * sin(Exact(theta));
    const double condition = static_cast<double>(Exact((s - aside) / abs(Exact(s + aside))));
    EXPECT_LE(error_ulp(bending_distance(d, phi, theta, s), printed_3(d, phi, theta, s)),
              kBoundUlp * condition)
        << "d " << d << " phi " << phi << " theta " << theta << " step " << s;
  }
}

TEST_F(ErrorModelNumerics, BendingDistanceIsATriangleSide) {
  for (int i = 0; i < 100000; ++i) {
    const double s = step(), theta = latitude();
    const double distance_m = bending_distance(distance(), latitude(), theta, s);
    EXPECT_LE(std::abs(distance_m), s);
    EXPECT_TRUE(theta < 0.0 || distance_m > 0.0);
  }
}

TEST_F(ErrorModelNumerics, BendingDistanceHasItsLimits) {
  for (int i = 0; i < 1000; ++i) {
    const double phi = latitude(), theta = latitude(), s = step();
    EXPECT_EQ(bending_distance(distance(), phi, theta, 0.0), 0.0);
    EXPECT_EQ(bending_distance(0.0, phi, theta, 0.0), 0.0);
    EXPECT_EQ(bending_distance(kInfinity, phi, theta, 0.0), 0.0);
    EXPECT_DOUBLE_EQ(bending_distance(0.0, phi, theta, s), s);
    EXPECT_DOUBLE_EQ(bending_distance(kInfinity, phi, theta, s), s * std::sin(theta));
    // Along the line the source is farther by the whole step.
    EXPECT_DOUBLE_EQ(bending_distance(distance(), phi, kHalfPi, s), s);
  }
}

TEST_F(ErrorModelNumerics, MismatchDistanceIsExactToFourUlpTimesItsCondition) {
  for (int i = 0; i < kSamples; ++i) {
    const CornerOffset offset = corner();
    const double a = offset.to_side_m, b = offset.to_front_m;
    // Half of the samples are beside the zero at the corner angle.
    const double angle_deg = corner_angle_deg(offset);
    const double k_deg =
        one_in(2) ? limit_deg() : std::max(45.0, angle_deg * (1.0 - log_uniform(1e-15, 1e-2)));
    const double actual = mismatch_distance(offset, k_deg);
    if (k_deg >= angle_deg) {
      EXPECT_EQ(actual, 0.0);
      continue;
    }
    const Exact exact = printed_8(a, b, k_deg);
    const double condition = static_cast<double>(Exact(a / abs(Exact(a - b * tan_deg(k_deg)))));
    EXPECT_LE(error_ulp(actual, exact), kBoundUlp * condition)
        << "a " << a << " b " << b << " k " << k_deg;
  }
}

TEST_F(ErrorModelNumerics, MismatchDistanceAtTheCornerAngleIsExactlyZero) {
  for (int i = 0; i < 100000; ++i) {
    const CornerOffset offset = corner();
    const double angle_deg = corner_angle_deg(offset);
    EXPECT_EQ(mismatch_distance(offset, angle_deg), 0.0);
    EXPECT_EQ(mismatch_distance(offset, std::min(90.0, angle_deg + 1e-9)), 0.0);
    EXPECT_EQ(mismatch_distance(offset, 90.0), 0.0);
  }
  for (const double k_deg : {45.0, 60.0, 90.0}) {
    EXPECT_EQ(mismatch_distance({0.0, 0.0}, k_deg), 0.0);
    EXPECT_EQ(mismatch_distance({0.0, 2.0}, k_deg), 0.0);
  }
}

TEST_F(ErrorModelNumerics, MismatchDistanceAtFortyFiveDegreesHasNoConditionLimit) {
  for (int i = 0; i < kSamples; ++i) {
    const double a = distance();
    const double b = a * (1.0 - log_uniform(1e-15, 1.0));
    EXPECT_LE(error_ulp(mismatch_distance({a, b}, 45.0), (Exact(a) - b) * sqrt(Exact(2))),
              kBoundUlp);
  }
}

TEST_F(ErrorModelNumerics, ScalingLengthsByAPowerOfTwoChangesNoBit) {
  for (int i = 0; i < 100000; ++i) {
    const double scale = std::ldexp(1.0, std::uniform_int_distribution<int>(-300, 300)(random_));
    const double d = distance(), phi = latitude(), theta = latitude(), s = step();
    EXPECT_EQ(latitude_shift(d * scale, phi, s * scale), latitude_shift(d, phi, s));
    EXPECT_EQ(bending_distance(d * scale, phi, theta, s * scale),
              bending_distance(d, phi, theta, s) * scale);
    const CornerOffset offset = corner();
    const CornerOffset scaled{offset.to_side_m * scale, offset.to_front_m * scale};
    const double k_deg = limit_deg();
    EXPECT_EQ(mismatch_distance(scaled, k_deg), mismatch_distance(offset, k_deg) * scale);
    EXPECT_EQ(corner_angle_deg(scaled), corner_angle_deg(offset));
  }
}

TEST_F(ErrorModelNumerics, NothingIsEverNanOrInfinite) {
  const std::vector<double> distances{0.0, 1e-300, 1e-6, 1.0, 1e8, 1e300, kInfinity};
  const std::vector<double> lengths{0.0, 1e-300, 1e-9, 1.0, 1e6, 1e300};
  const std::vector<double> angles{-kHalfPi, -1e-300, -0.0, 0.0, 1e-300, 0.5, kHalfPi};
  for (const double s : lengths) {
    for (const double b : lengths) {
      for (const double k_deg : {45.0, 76.0, std::nextafter(90.0, 0.0), 90.0}) {
        EXPECT_TRUE(std::isfinite(mismatch_distance({s, b}, k_deg))) << s << " " << b;
      }
    }
    for (const double d : distances) {
      for (const double phi : angles) {
        EXPECT_TRUE(std::isfinite(latitude_shift(d, phi, s))) << d << " " << phi << " " << s;
        for (const double theta : angles) {
          EXPECT_TRUE(std::isfinite(bending_distance(d, phi, theta, s)))
              << d << " " << phi << " " << theta << " " << s;
        }
      }
    }
  }
}

TEST_F(ErrorModelNumerics, CornerAngleIsExactToFourUlp) {
  for (int i = 0; i < kSamples; ++i) {
    const CornerOffset offset = corner();
    const Exact exact = atan2(Exact(offset.to_side_m), Exact(offset.to_front_m)) * 180 / exact_pi();
    EXPECT_LE(error_ulp(corner_angle_deg(offset), exact), kBoundUlp);
  }
  EXPECT_EQ(corner_angle_deg({3.0, 3.0}), 45.0);
  EXPECT_EQ(corner_angle_deg({3.0, 0.0}), 90.0);
  EXPECT_EQ(corner_angle_deg({0.0, 3.0}), 0.0);
}

TEST(ConnectionErrorCurve, IsTheSumOfTheEquations) {
  // (7) and (10) in the paper's own coordinates and over all of their terms.
  const CellSampling sampling{.side_m = 2.0, .step_m = 0.1, .viewpoints = 4};
  const double d = 2.7;
  const int k_deg = 63;
  double mismatch_rad = 0.0, bending_rad = 0.0;
  for (int j = -90; j <= 90; ++j) {
    const double phi = radians_from_degrees(j);
    for (const double x : {-0.75, -0.25, 0.25, 0.75}) {
      for (const double z : {-0.75, -0.25, 0.25, 0.75}) {
        const CornerOffset offset{std::max(1.0 - x, 1.0 - z), std::min(1.0 - x, 1.0 - z)};
        mismatch_rad += std::abs(latitude_shift(d, phi, mismatch_distance(offset, k_deg)));
      }
    }
    for (int i = 0; i <= k_deg; ++i) {
      const double apart = bending_distance(d, phi, radians_from_degrees(i), sampling.step_m);
      bending_rad += std::abs(latitude_shift(d, phi, std::abs(apart)));
    }
  }
  const ConnectionErrorCurve curve = connection_error_curve(sampling, d);
  EXPECT_NEAR(curve.mismatch_rad[k_deg - 45], mismatch_rad, 1e-10);
  EXPECT_NEAR(curve.bending_rad[k_deg - 45], bending_rad, 1e-10);
}

TEST(ConnectionErrorCurve, HasTheShapeOfFigure11a) {
  const ConnectionErrorCurve curve = connection_error_curve({}, 1.5);
  for (std::size_t i = 1; i < curve.total.size(); ++i) {
    EXPECT_LT(curve.mismatch_rad[i], curve.mismatch_rad[i - 1]) << i;
    EXPECT_GT(curve.bending_rad[i], curve.bending_rad[i - 1]) << i;
  }
  EXPECT_EQ(curve.mismatch_rad.back(), 0.0);
  EXPECT_EQ(curve.total.back(), 1.0);
  EXPECT_DOUBLE_EQ(curve.total.front(), 1.0 + curve.bending_rad.front() / curve.bending_rad.back());
  const std::size_t optimum = static_cast<std::size_t>(curve.optimum_k_deg - 45);
  EXPECT_EQ(curve.total[optimum], *std::ranges::min_element(curve.total));
}

TEST(ConnectionErrorCurve, OptimumFallsWithDistanceAtACoarseStepOnly) {
  const auto optimum_k_deg = [](double step_m, double d_src_m) {
    return connection_error_curve({.step_m = step_m}, d_src_m).optimum_k_deg;
  };
  EXPECT_EQ(optimum_k_deg(0.01, 1.2), 73);
  EXPECT_EQ(optimum_k_deg(0.01, 1.5), 72);
  EXPECT_EQ(optimum_k_deg(0.01, 2.5), 72);
  EXPECT_EQ(optimum_k_deg(0.15, 1.2), 78);
  EXPECT_EQ(optimum_k_deg(0.15, 1.5), 76);  // the paper's value
  EXPECT_EQ(optimum_k_deg(0.15, 2.0), 75);
  EXPECT_EQ(optimum_k_deg(0.15, 2.5), 74);
}

TEST(ConnectionErrorCurve, DependsOnRatiosOfLengthsOnly) {
  const ConnectionErrorCurve unit =
      connection_error_curve({.side_m = 1.0, .step_m = 0.15, .viewpoints = 9}, 1.5);
  const ConnectionErrorCurve twice =
      connection_error_curve({.side_m = 4.0, .step_m = 0.60, .viewpoints = 9}, 6.0);
  EXPECT_EQ(unit.mismatch_rad, twice.mismatch_rad);
  EXPECT_EQ(unit.bending_rad, twice.bending_rad);
}

TEST(ConnectionErrorCurve, ConnectsPhysicallyWithoutBendingAndAtInfinity) {
  const ConnectionErrorCurve dense = connection_error_curve({.step_m = 0.0, .viewpoints = 5}, 1.5);
  EXPECT_THAT(dense.bending_rad, testing::Each(0.0));
  EXPECT_EQ(dense.total.front(), 1.0);
  EXPECT_EQ(dense.optimum_k_deg, 90);
  const ConnectionErrorCurve far = connection_error_curve({.viewpoints = 5}, kInfinity);
  EXPECT_THAT(far.total, testing::Each(0.0));
  EXPECT_EQ(far.optimum_k_deg, 90);
}

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

// Inverse distance of the layer nearest to `inverse`.
double layer_of(double inverse, InverseRange range, int count) {
  const double step = (range.max - range.min) / count;
  const double index = std::clamp(std::floor((inverse - range.min) / step), 0.0, count - 1.0);
  return range.min + (index + 0.5) * step;
}

class Spacing : public Numerics {
 protected:
  double inverse_distance() { return one_in(10) ? 0.0 : log_uniform(1e-12, 1e9); }
};

// The header's bounds for other directions and for other positions between the stations.
TEST_F(Spacing, OtherDirectionsAndPositionsAreHardlyWorse) {
  double most = 0.0;
  for (int i = 0; i < 20 * kSamples; ++i) {
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
  for (int i = 0; i < kSamples; ++i) {
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
  for (int i = 0; i < kSamples; ++i) {
    const double near = log_uniform(1e-2, 1e3);
    const InverseRange scene{one_in(3) ? 0.0 : uniform(0.0, 1.0) / near, 1.0 / near};
    const int layers = std::uniform_int_distribution<int>(1, 40)(random_);
    const double tolerance = log_uniform(1e-6, 0.05);
    const double spacing = spacing_needed(scene, inverse_error_of_layers(scene, layers), tolerance);
    if (std::isinf(spacing)) continue;
    for (int source = 0; source < 20; ++source) {
      const double inverse = uniform(scene.min, scene.max);
      const double assumed = layer_of(inverse, scene, layers);
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
  EXPECT_EQ(spacing_needed_without_depth({0.0, 0.0}, 1e-3), kInfinity);
  EXPECT_EQ(spacing_needed({0.5, 0.5}, 0.0, 1e-3), kInfinity);
  EXPECT_EQ(largest_ghost_without_depth({0.0, 0.0}, 10.0), 0.0);
  EXPECT_EQ(nearest_distance_resolved(0.0, 1e-3), 0.0);
}

TEST_F(Spacing, PixelsAreAngles) {
  EXPECT_DOUBLE_EQ(angle_of_pixels(1024.0, 1024), kTwoPi);
  EXPECT_DOUBLE_EQ(angle_of_pixels(0.5, 360), radians_from_degrees(0.5));
}

using LayerCount = Numerics;

TEST_F(LayerCount, CountKeepsEveryPixelWithinTheTolerance) {
  const double most_q = std::sin(radians_from_degrees(80.0));
  double worst = 0.0;
  for (int scene = 0; scene < 200; ++scene) {
    const double nearest_m = log_uniform(0.1, 100.0);
    const InverseRange range{uniform(0.0, 1.0) / nearest_m, 1.0 / nearest_m};
    const double d_p = nearest_m * log_uniform(0.01, 10.0);
    const double tolerance = log_uniform(5e-4, 1e-3);
    const int count = layers_for_tolerance(range, d_p, tolerance);
    ASSERT_LT(count, 65536);
    for (int i = 0; i < 500; ++i) {
      const double phi = uniform(-kHalfPi, kHalfPi);
      const double inverse = uniform(range.min, range.max);
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

TEST_F(LayerCount, NoCorrectionNeedsOneLayer) {
  EXPECT_EQ(layers_for_tolerance({0.5, 0.5}, 1.0, 1e-3), 1);
  EXPECT_EQ(layers_for_tolerance({0.1, 2.0}, 0.0, 1e-3), 1);
  EXPECT_EQ(layers_for_tolerance({0.0, 0.0}, 1.0, 1e-3), 1);
}

TEST_F(LayerCount, CountIsBoundedForScenesThatTouchTheLine) {
  EXPECT_EQ(layers_for_tolerance({0.0, 1e12}, 1.0, 1e-4), 65536);
  EXPECT_EQ(layers_for_tolerance({0.0, 1.0}, 1e300, 1e-300), 65536);
}

}  // namespace
}  // namespace raywalk
