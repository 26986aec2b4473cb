#include "render/view/depth_layers.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"

namespace raywalk {

int layers_for_tolerance(OmegaRange range, double largest_d_p_m, double tolerance_rad) {
  constexpr int kMostLayers = 65536;
  const double largest_q = std::sin(radians_from_degrees(80.0));
  const double q = std::min(largest_q, largest_d_p_m * range.max);
  const double slope = largest_d_p_m / std::sqrt(1.0 - q * q);
  const double layers = 0.5 * slope * (range.max - range.min) / tolerance_rad;
  if (!(layers < kMostLayers)) return kMostLayers;
  return std::max(1, static_cast<int>(std::ceil(layers)));
}

LayerSpacing layer_spacing(OmegaRange range, int count) {
  // A scene at one distance is one layer there; a hair of width keeps the spacing positive.
  const double width = std::max(range.max - range.min, 1e-6 * std::max(range.max, 1e-6));
  return {static_cast<float>(range.min), static_cast<float>(width / count)};
}

}  // namespace raywalk
