#include "core/geometry/connection_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(ConnectionErrorCurve, IsTheSumOfTheEquations) {
  // (7) and (10) term by term, in the paper's own coordinates and over all of its terms.
  const CellSampling sampling{.side_m = 2.0, .step_m = 0.1, .viewpoints = 4};
  const double d = 2.7;
  const int k_deg = 63;
  double mismatch_rad = 0.0;
  for (const double x : {-0.75, -0.25, 0.25, 0.75}) {
    for (const double z : {-0.75, -0.25, 0.25, 0.75}) {
      const double a = std::max(1.0 - x, 1.0 - z);
      const double b = std::min(1.0 - x, 1.0 - z);
      const double k = radians_from_degrees(k_deg);
      const double apart = std::max(0.0, (a - b * std::tan(k)) / std::cos(kHalfPi - k));
      for (int j = -90; j <= 90; ++j) {
        const double phi = radians_from_degrees(j);
        mismatch_rad += std::abs(phi - std::atan2(d * std::sin(phi), d * std::cos(phi) + apart));
      }
    }
  }
  double bending_rad = 0.0;
  for (int i = 0; i <= k_deg; ++i) {
    const double theta = radians_from_degrees(i);
    for (int j = -90; j <= 90; ++j) {
      const double phi = radians_from_degrees(j);
      const double c = d * std::cos(phi);
      const double apart =
          std::hypot(c * std::cos(theta), c * std::sin(theta) + sampling.step_m) - c;
      bending_rad += std::abs(phi - std::atan2(d * std::sin(phi), c + std::abs(apart)));
    }
  }
  const ConnectionErrorCurve curve = connection_error_curve(sampling, {{d}});
  EXPECT_NEAR(curve.mismatch_rad[k_deg - 45], mismatch_rad, 1e-10);
  EXPECT_NEAR(curve.bending_rad[k_deg - 45], bending_rad, 1e-10);
}

TEST(ConnectionErrorCurve, HasTheShapeOfFigure11a) {
  const ConnectionErrorCurve curve = connection_error_curve({}, {{1.5}});
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

int optimum_k_deg(double step_m, double d_src_m) {
  return connection_error_curve({.step_m = step_m}, {{d_src_m}}).optimum_k_deg;
}

TEST(ConnectionErrorCurve, OptimumHardlyDependsOnDistanceAtAFineStep) {
  EXPECT_EQ(optimum_k_deg(0.01, 1.2), 73);
  EXPECT_EQ(optimum_k_deg(0.01, 1.5), 72);
  EXPECT_EQ(optimum_k_deg(0.01, 2.5), 72);
}

TEST(ConnectionErrorCurve, OptimumFallsWithDistanceAtACoarseStep) {
  EXPECT_EQ(optimum_k_deg(0.15, 1.2), 78);
  EXPECT_EQ(optimum_k_deg(0.15, 1.5), 76);  // the paper's value
  EXPECT_EQ(optimum_k_deg(0.15, 2.0), 75);
  EXPECT_EQ(optimum_k_deg(0.15, 2.5), 74);
}

TEST(ConnectionErrorCurve, DependsOnRatiosOfLengthsOnly) {
  const ConnectionErrorCurve unit =
      connection_error_curve({.side_m = 1.0, .step_m = 0.15, .viewpoints = 9}, {{1.5}});
  const ConnectionErrorCurve twice =
      connection_error_curve({.side_m = 4.0, .step_m = 0.60, .viewpoints = 9}, {{6.0}});
  EXPECT_EQ(unit.mismatch_rad, twice.mismatch_rad);
  EXPECT_EQ(unit.bending_rad, twice.bending_rad);
}

TEST(ConnectionErrorCurve, AddsUpOverDistances) {
  const CellSampling sampling{.viewpoints = 5};
  const ConnectionErrorCurve near = connection_error_curve(sampling, {{1.0}});
  const ConnectionErrorCurve far = connection_error_curve(sampling, {{30.0}});
  const std::vector<double> distances{1.0, 30.0};
  const ConnectionErrorCurve both = connection_error_curve(sampling, distances);
  for (std::size_t i = 0; i < both.total.size(); ++i) {
    EXPECT_DOUBLE_EQ(both.mismatch_rad[i], near.mismatch_rad[i] + far.mismatch_rad[i]);
    EXPECT_DOUBLE_EQ(both.bending_rad[i], near.bending_rad[i] + far.bending_rad[i]);
  }
}

TEST(ConnectionErrorCurve, ConnectsPhysicallyWithoutBending) {
  const ConnectionErrorCurve curve =
      connection_error_curve({.step_m = 0.0, .viewpoints = 5}, {{1.5}});
  EXPECT_THAT(curve.bending_rad, testing::Each(0.0));
  EXPECT_EQ(curve.total.front(), 1.0);
  EXPECT_EQ(curve.optimum_k_deg, 90);
}

TEST(ConnectionErrorCurve, HasNoErrorAtInfinity) {
  const ConnectionErrorCurve curve = connection_error_curve({.viewpoints = 5}, {{kInfinity}});
  EXPECT_THAT(curve.total, testing::Each(0.0));
  EXPECT_EQ(curve.optimum_k_deg, 90);
}

TEST(ConnectionErrorCurve, RejectsArgumentsOutsideTheDomain) {
  const std::vector<double> one{1.0};
  EXPECT_THROW(connection_error_curve({.side_m = 0.0}, one), Error);
  EXPECT_THROW(connection_error_curve({.side_m = kInfinity}, one), Error);
  EXPECT_THROW(connection_error_curve({.step_m = -0.1}, one), Error);
  EXPECT_THROW(connection_error_curve({.step_m = std::nan("")}, one), Error);
  EXPECT_THROW(connection_error_curve({.viewpoints = 0}, one), Error);
  EXPECT_THROW(connection_error_curve({}, {}), Error);
  EXPECT_THROW(connection_error_curve({}, {{-1.0}}), Error);
  EXPECT_THROW(connection_error_curve({}, {{std::nan("")}}), Error);
}

}  // namespace
}  // namespace raywalk
