#include "core/geometry/connection_error.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/geometry/error_model.h"
#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

using Values = ConnectionErrorCurve::Values;

// The sum over latitude rows j = -90..90 degrees of |shift(phi_j)|, for a shift that is odd in phi.
template <typename Shift>
double sum_over_latitude_rows(const Shift& shift) {
  double sum = 0.0;
  for (int row = 1; row <= 90; ++row) sum += shift(radians_from_degrees(row));
  return 2.0 * sum;
}

// (7) at one k and distance. A viewpoint with b > a is measured from the other line, that is with a
// and b exchanged, so it mirrors one with a > b; for a = b the corner is at 45 degrees and D_m is 0
// at every k. The whole sum is therefore twice the sum over a > b.
double mismatch_error(const CellSampling& sampling, double d_src_m, double k_deg) {
  const double spacing_m = sampling.side_m / sampling.viewpoints;
  double sum = 0.0;
  for (int side = 1; side < sampling.viewpoints; ++side) {
    for (int front = 0; front < side; ++front) {
      const double apart_m =
          mismatch_distance({(side + 0.5) * spacing_m, (front + 0.5) * spacing_m}, k_deg);
      if (apart_m == 0.0)
        break;  // it increases with the corner angle, which decreases from here on
      sum += sum_over_latitude_rows(
          [&](double phi_rad) { return latitude_shift(d_src_m, phi_rad, apart_m); });
    }
  }
  return 2.0 * sum;
}

// One column theta of (10).
double bending_error_of_column(const CellSampling& sampling, double d_src_m, double theta_rad) {
  return sum_over_latitude_rows([&](double phi_rad) {
    const double apart_m = bending_distance(d_src_m, phi_rad, theta_rad, sampling.step_m);
    return latitude_shift(d_src_m, phi_rad, apart_m);
  });
}

void add_mismatch_errors(const CellSampling& sampling, double d_src_m, Values* sums) {
  for (std::size_t i = 0; i < sums->size(); ++i) {
    const double k_deg = static_cast<double>(i) + ConnectionErrorCurve::kMinDeg;
    (*sums)[i] += mismatch_error(sampling, d_src_m, k_deg);
  }
}

void add_bending_errors(const CellSampling& sampling, double d_src_m, Values* sums) {
  double sum = 0.0;
  for (int theta_deg = 0; theta_deg <= ConnectionErrorCurve::kMaxDeg; ++theta_deg) {
    sum += bending_error_of_column(sampling, d_src_m, radians_from_degrees(theta_deg));
    if (theta_deg < ConnectionErrorCurve::kMinDeg) continue;
    (*sums)[static_cast<std::size_t>(theta_deg - ConnectionErrorCurve::kMinDeg)] += sum;
  }
}

double share_of(double value, double max) { return max > 0.0 ? value / max : 0.0; }

void require(bool valid, const std::string& what) {
  if (!valid) throw Error("error model: " + what);
}

void check_domain(const CellSampling& sampling, std::span<const double> d_src_m) {
  require(std::isfinite(sampling.side_m) && sampling.side_m > 0.0,
          "the cell's side must be positive and finite, not " + std::to_string(sampling.side_m));
  require(std::isfinite(sampling.step_m) && sampling.step_m >= 0.0,
          "the station step must be at least 0 and finite, not " + std::to_string(sampling.step_m));
  require(sampling.viewpoints >= 1, "there must be at least one viewpoint per side, not " +
                                        std::to_string(sampling.viewpoints));
  require(!d_src_m.empty(), "there must be at least one source distance");
  for (const double distance_m : d_src_m) {
    require(distance_m >= 0.0,
            "a source distance must be at least 0, not " + std::to_string(distance_m));
  }
}

}  // namespace

ConnectionErrorCurve connection_error_curve(const CellSampling& sampling,
                                            std::span<const double> d_src_m) {
  check_domain(sampling, d_src_m);
  ConnectionErrorCurve curve;
  for (const double distance_m : d_src_m) {
    add_mismatch_errors(sampling, distance_m, &curve.mismatch_rad);
    add_bending_errors(sampling, distance_m, &curve.bending_rad);
  }
  const double max_mismatch_rad = *std::ranges::max_element(curve.mismatch_rad);
  const double max_bending_rad = *std::ranges::max_element(curve.bending_rad);
  double least = 0.0;
  for (std::size_t i = 0; i < curve.total.size(); ++i) {
    curve.total[i] = share_of(curve.mismatch_rad[i], max_mismatch_rad) +
                     share_of(curve.bending_rad[i], max_bending_rad);
    if (i > 0 && curve.total[i] > least) continue;
    least = curve.total[i];
    curve.optimum_k_deg = static_cast<int>(i) + ConnectionErrorCurve::kMinDeg;
  }
  return curve;
}

}  // namespace raywalk
