// Sample positions in float and in double against geometry in long double, over the whole range of
// rendering: distances of 1e-6..1e8 m, stations 1e-6..10 m from the acquisition point, every
// latitude, columns at 45 and at 90 degrees from a line's normal.
#include "core/view/precise_positions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/view/test_columns.h"

namespace raywalk {
namespace {

constexpr PanoramaSize kPrecisePanorama{16384, 8192};
constexpr double kRadPerPixel = kTwoPi / kPrecisePanorama.width;
constexpr int kCases = 200000;

// One point as a station sees it.
struct Case {
  int row = 0;
  float omega = 0.0f;
  double theta_rad = 0.0;
  Eigen::Vector3d displacement_m{0, 0, 0};  // viewpoint - station
};

// A direction in the column's frame, of any length but zero.
struct Seen {
  long double forward = 0.0L, up = 0.0L, side = 0.0L;
  long double plan() const { return std::hypot(forward, side); }
  long double length() const { return std::hypot(forward, up, side); }
};

Seen exactly_seen(const Case& c) {
  const long double pi = std::acos(-1.0L);
  const long double phi = pi / 2.0L - (c.row + 0.5L) / kPrecisePanorama.height * pi;
  const long double s = std::sin(static_cast<long double>(c.theta_rad));
  const long double t = std::cos(static_cast<long double>(c.theta_rad));
  const long double omega = c.omega;
  const Eigen::Vector3d& d = c.displacement_m;
  return {std::cos(phi) + omega * (d.x() * s + d.z() * t), std::sin(phi) + omega * d.y(),
          omega * (d.x() * t - d.z() * s)};
}

// Factor that magnifies rounding where a point's direction and its offset nearly cancel.
double cancellation(const Case& c, const Seen& seen) {
  return static_cast<double>((1.0L + c.omega * static_cast<long double>(c.displacement_m.norm())) /
                             seen.length());
}

// The angle between a sample and its exact position, radians.
double angle_off(const SampleArrays& samples, const Case& c, const Seen& seen) {
  const int sample = samples.left[0] / 3;
  const int column = sample / kPrecisePanorama.height;
  const double u = column + weight_of(samples.weight_right[0]) / 32768.0;
  const double v = sample % kPrecisePanorama.height + weight_of(samples.weight_lower[0]) / 32768.0;
  const auto turn = static_cast<double>(std::atan2(seen.side, seen.forward));
  const auto latitude = static_cast<double>(std::atan2(seen.up, seen.plan()));
  const double exact_u =
      pixel_from_angles({c.theta_rad, 0.0}, kPrecisePanorama).u + turn / kRadPerPixel;
  const double exact_v =
      std::clamp((kHalfPi - latitude) / kRadPerPixel - 0.5, 0.0, kPrecisePanorama.height - 1.0);
  const double du = std::remainder(u - exact_u, kPrecisePanorama.width) * std::cos(latitude);
  return std::hypot(du, v - exact_v) * kRadPerPixel;
}

// The front line's column at `incidence_rad`, a viewpoint up to 1 m from the line (on it where the
// column runs along it), and a station up to 10 m to either side of where the ray crosses.
Case random_case(RandomColumns* random, double incidence_rad) {
  const auto log_uniform = [&](double least, double most) {
    return std::exp(random->uniform(std::log(least), std::log(most)));
  };
  const double along_line = incidence_rad < kHalfPi ? 1.0 / std::cos(incidence_rad) : 0.0;
  const double d_p_m = along_line * log_uniform(1e-6, 1.0);
  const double side = random->uniform(-1.0, 1.0) < 0.0 ? -1.0 : 1.0;
  const double step_m = side * log_uniform(1e-6, 10.0);
  Case c;
  // Half of them near the zenith.
  c.row = static_cast<int>(step_m < 0.0 ? random->uniform(0.0, kPrecisePanorama.height)
                                        : log_uniform(1.0, kPrecisePanorama.height) - 1.0);
  c.omega = static_cast<float>(1.0 / log_uniform(1e-6, 1e8));
  c.theta_rad = incidence_rad;
  const Eigen::Vector3d ray(std::sin(c.theta_rad), 0.0, std::cos(c.theta_rad));
  c.displacement_m = -(d_p_m * ray + Eigen::Vector3d(step_m, 1e-3 * step_m, 0.0));
  return c;
}

// In LFU the lines connect at 45 degrees; in Ray-space360 a line is used up to its own direction.
const double kIncidencesRad[] = {radians_from_degrees(45.0), kHalfPi - 0.5 * kRadPerPixel, kHalfPi};

// Positions are multiples of 1/32768 pixel.
constexpr double kUnitRad = kRadPerPixel / 32768.0;

TEST(PrecisePositions, AreExactToTheirResolution) {
  RandomColumns random(7);
  const PrecisePositions precise(kPrecisePanorama.height);
  SampleArrays samples(1);
  for (const double incidence_rad : kIncidencesRad) {
    for (int i = 0; i < kCases; ++i) {
      const Case c = random_case(&random, incidence_rad);
      const Seen seen = exactly_seen(c);
      precise.find(c.row, {&c.omega, 1}, c.displacement_m, c.theta_rad, kPrecisePanorama,
                   samples.positions());
      ASSERT_LE(angle_off(samples, c, seen), kUnitRad + 4e-16 * cancellation(c, seen))
          << "row " << c.row << " omega " << c.omega;
    }
  }
}

class FloatPositions : public Kernels {};
INSTANTIATE_TEST_SUITE_P(Sets, FloatPositions, testing::Values("generic", "avx2"), kernel_set_name);

// The error of fast_atan2 is 5.5e-7 rad, that of four roundings of 2^-24 is 2.4e-7.
TEST_P(FloatPositions, ErrorIsThatOfTheArctangentAndCancellation) {
  const LatitudeTable latitudes(kPrecisePanorama.height, kPrecisePanorama.height);
  SampleArrays samples(1);
  for (const double incidence_rad : kIncidencesRad) {
    const double ahead_u = pixel_from_angles({incidence_rad, 0.0}, kPrecisePanorama).u;
    const ColumnPosition ahead = split_column(ahead_u, kPrecisePanorama.width);
    for (int i = 0; i < kCases; ++i) {
      const Case c = random_case(&random_, incidence_rad);
      const Seen seen = exactly_seen(c);
      kernels_->find_samples(
          latitudes.table(c.row), &c.omega, 1, column_offset(c.displacement_m, c.theta_rad),
          {kPrecisePanorama.width, kPrecisePanorama.height, ahead.whole, ahead.part},
          samples.positions());
      ASSERT_LE(angle_off(samples, c, seen), kUnitRad + 5.5e-7 + 2.4e-7 * cancellation(c, seen))
          << "row " << c.row << " omega " << c.omega;
    }
  }
}

}  // namespace
}  // namespace raywalk
