#include "core/geometry/layer_count.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"

namespace raywalk {

int layers_for_tolerance(OmegaRange range, double largest_d_p_m, double tolerance_rad) {
  constexpr int kMaxLayers = 65536;
  const double largest_q = std::sin(radians_from_degrees(80.0));
  const double q = std::min(largest_q, largest_d_p_m * range.max);
  const double slope = largest_d_p_m / std::sqrt(1.0 - q * q);
  const double layers = 0.5 * slope * (range.max - range.min) / tolerance_rad;
  if (!(layers < kMaxLayers)) return kMaxLayers;
  return std::max(1, static_cast<int>(std::ceil(layers)));
}

}  // namespace raywalk
