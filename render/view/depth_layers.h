// The depth layers of a view; core/geometry/layer_count.h says how many it needs.
#pragma once

#include "core/geometry/layer_count.h"
#include "render/view/column_kernels.h"

namespace raywalk::render {

// The spacing of `count` (>= 1) layers over a range.
LayerSpacing layer_spacing(OmegaRange range, int count);

}  // namespace raywalk::render
