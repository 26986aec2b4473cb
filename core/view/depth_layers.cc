#include "core/view/depth_layers.h"

#include <algorithm>

namespace raywalk {

LayerSpacing layer_spacing(OmegaRange range, int count) {
  // A scene at a single distance has one layer there; a minimal width keeps the spacing positive.
  const double width = std::max(range.max - range.min, 1e-6 * std::max(range.max, 1e-6));
  return {static_cast<float>(range.min), static_cast<float>(width / count)};
}

}  // namespace raywalk
