#include "core/geometry/spacing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

// With T = tan(tolerance / 2) and D = |w - w_0| the ghost reaches the tolerance where
//   h D = T (1 + h^2 w w_0),   h = step / 2,
// a quadratic in h whose smaller root, written without cancellation, is
//   h = 2 T / (D + sqrt((D - R)(D + R))),   R = 2 T sqrt(w w_0).
// If D < R there is no root: the ghost never reaches the tolerance.
double step_for_difference(double tolerance_rad, double difference, double inverse,
                           double assumed_inverse) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double tangent = std::tan(0.5 * tolerance_rad);
  const double reach = 2.0 * tangent * (std::sqrt(inverse) * std::sqrt(assumed_inverse));
  if (difference == 0.0 || difference < reach) return kInfinity;
  const double ratio = reach / difference;  // within [0, 1]: nothing overflows below
  return 4.0 * (tangent / difference) / (1.0 + std::sqrt((1.0 - ratio) * (1.0 + ratio)));
}

}  // namespace

double angle_of_pixels(double tolerance_px, int width_px) {
  return tolerance_px * (kTwoPi / width_px);
}

double inverse_error_of_layers(InverseRange scene, int layers) {
  return 0.5 * (scene.max - scene.min) / layers;
}

// For a given error the ghost decreases with the product of the two inverse distances, so the worst
// case is the farthest source, assumed nearer than it is.
double spacing_needed(InverseRange scene, double inverse_error, double tolerance_rad) {
  return step_for_difference(tolerance_rad, inverse_error, scene.min, scene.min + inverse_error);
}

double spacing_needed_without_depth(InverseRange scene, double tolerance_rad) {
  return step_for_difference(tolerance_rad, scene.max, scene.max, 0.0);
}

double largest_ghost_without_depth(InverseRange scene, double spacing_m) {
  return 2.0 * std::atan(0.5 * spacing_m * scene.max);
}

double nearest_distance_resolved(double spacing_m, double tolerance_rad) {
  return 0.5 * spacing_m / std::tan(0.5 * tolerance_rad);
}

int layers_for_tolerance(InverseRange range, double largest_d_p_m, double tolerance_rad) {
  constexpr int kMaxLayers = 65536;
  const double largest_q = std::sin(radians_from_degrees(80.0));
  const double q = std::min(largest_q, largest_d_p_m * range.max);
  const double slope = largest_d_p_m / std::sqrt(1.0 - q * q);
  const double layers = 0.5 * slope * (range.max - range.min) / tolerance_rad;
  if (!(layers < kMaxLayers)) return kMaxLayers;
  return std::max(1, static_cast<int>(std::ceil(layers)));
}

}  // namespace raywalk
