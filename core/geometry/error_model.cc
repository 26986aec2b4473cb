#include "core/geometry/error_model.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

// Trigonometry of k in [45, 90] degrees via its complement 90 - k, which is exact in double, so
// that tan k keeps full precision as k approaches 90 degrees.
struct LimitAngle {
  explicit LimitAngle(double k_deg) {
    const double complement_rad = radians_from_degrees(90.0 - k_deg);
    sine = std::cos(complement_rad);
    // pi/4 is not a double, so its tangent would not be 1.
    tangent = k_deg == 45.0 ? 1.0 : 1.0 / std::tan(complement_rad);
  }
  double sine;
  double tangent;  // infinity at 90 degrees
};

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

// (10) at one distance.
Values bending_errors(const CellSampling& sampling, double d_src_m) {
  Values errors{};
  double sum = 0.0;
  for (int theta_deg = 0; theta_deg <= ConnectionErrorCurve::kMaxDeg; ++theta_deg) {
    sum += bending_error_of_column(sampling, d_src_m, radians_from_degrees(theta_deg));
    if (theta_deg < ConnectionErrorCurve::kMinDeg) continue;
    errors[static_cast<std::size_t>(theta_deg - ConnectionErrorCurve::kMinDeg)] = sum;
  }
  return errors;
}

double share_of(double value, double max) { return max > 0.0 ? value / max : 0.0; }

}  // namespace

double latitude_shift(double d_src_m, double phi_rad, double apart_m) {
  if (apart_m == 0.0 || std::isinf(d_src_m)) return std::copysign(0.0, phi_rad);
  // (2) and (4) are the angle between v = d (cos phi, sin phi) and w = v + (D, 0). It has
  //   w x v = (d cos phi + D) d sin phi - d sin phi d cos phi = d D sin phi,
  //   w . v = d^2 + d D cos phi,
  // so it is atan2(D sin phi, d + D cos phi), without cancellation. Dividing both by D avoids
  // underflow and keeps every rounding error relative to the result.
  const double shift_rad = std::atan2(std::sin(phi_rad), d_src_m / apart_m + std::cos(phi_rad));
  return std::copysign(std::min(std::abs(shift_rad), std::abs(phi_rad)), phi_rad);
}

double bending_distance(double d_src_m, double phi_rad, double theta_rad, double step_m) {
  if (step_m == 0.0) return 0.0;
  // (3) is D_b = h - c with c = d cos phi and h = hypot(c cos theta, c sin theta + s). Multiplied
  // by (h + c) / (h + c), as h^2 - c^2 = s (2 c sin theta + s):
  //   D_b = s (2 c sin theta + s) / (h + c).
  // This form has no cancellation; fma avoids the rounding of each product.
  const double c = d_src_m * std::cos(phi_rad);
  const double sine = std::sin(theta_rad);
  if (std::isinf(c)) return step_m * sine;
  const double farther = std::hypot(c * std::cos(theta_rad), std::fma(c, sine, step_m));
  const double distance_m = step_m * (std::fma(2.0 * c, sine, step_m) / (farther + c));
  // The triangle inequality, |D_b| <= s; rounding must not break it.
  return std::clamp(distance_m, -step_m, step_m);
}

double corner_angle_deg(CornerOffset corner) {
  return degrees_from_radians(std::atan2(corner.to_side_m, corner.to_front_m));
}

double mismatch_distance(CornerOffset corner, double k_deg) {
  // The ray of incidence k crosses the front line at b tan k; from there its distance to the side
  // line, at a, is (a - b tan k) / sin k. That is (8); with c = atan2(a, b) it equals hypot(a, b)
  // sin(c - k) / (sin k cos k). The first form is used: with fma the difference is rounded once, so
  // as k approaches c only the rounding error of tan k is magnified, and at 45 degrees tan k is
  // exact.
  if (k_deg >= 90.0 || k_deg >= corner_angle_deg(corner)) return 0.0;
  const LimitAngle k(k_deg);
  return std::max(0.0, std::fma(-corner.to_front_m, k.tangent, corner.to_side_m) / k.sine);
}

ConnectionErrorCurve connection_error_curve(const CellSampling& sampling, double d_src_m) {
  ConnectionErrorCurve curve;
  for (std::size_t i = 0; i < curve.mismatch_rad.size(); ++i) {
    const double k_deg = static_cast<double>(i) + ConnectionErrorCurve::kMinDeg;
    curve.mismatch_rad[i] = mismatch_error(sampling, d_src_m, k_deg);
  }
  curve.bending_rad = bending_errors(sampling, d_src_m);
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
