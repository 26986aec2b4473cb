// The depth layers of a view; core/geometry/layer_count.h computes their number.
#pragma once

#include "core/geometry/layer_count.h"
#include "core/view/column_kernels.h"

namespace raywalk {

// The spacing of `count` (>= 1) layers over a range of inverse distances, 1/m.
LayerSpacing layer_spacing(OmegaRange range, int count);

}  // namespace raywalk
