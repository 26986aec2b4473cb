#include "core/geometry/error_model.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

double corrected_latitude(double d_src_m, double d_p_m, double phi_rad) {
  if (d_p_m == 0.0 || std::isinf(d_src_m)) return phi_rad;
  // (5) with both arguments divided by d_src, which cannot overflow the products.
  const double corrected_rad = std::atan2(std::sin(phi_rad), std::cos(phi_rad) + d_p_m / d_src_m);
  if (d_p_m < 0.0) return corrected_rad;
  // Correction towards the horizon never increases |phi|; rounding must not either.
  return std::copysign(std::min(std::abs(corrected_rad), std::abs(phi_rad)), phi_rad);
}

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

ConnectionRange connection_range(CornerOffset corner) {
  const auto [nearer_m, farther_m] = std::minmax(corner.to_side_m, corner.to_front_m);
  return {45.0, std::max(45.0, corner_angle_deg({farther_m, nearer_m}))};
}

}  // namespace raywalk
