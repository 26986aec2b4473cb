// Semi-global matching (Hirschmueller 2008): distances with low matching cost that are smooth
// except at edges of the picture.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <vector>

#include "build_lf/depth/plane_sweep.h"

namespace raywalk::build_lf {

// Reusable memory: 2 bytes per pixel and layer.
struct SemiGlobalScratch {
  std::pmr::vector<std::uint16_t> sum;
};

// The inverse distance of every pixel of a swept reference: the layer with the smallest sum of path
// costs from eight directions, interpolated by a parabola. Confidence is the margin to the best
// layer that is not adjacent; 0 where nothing could be compared. Paths wrap around the sphere: rows
// through the seam, columns over the poles.
InverseDistanceMap regularise(const CostVolume& volume, const SweepReference& reference,
                              SemiGlobalScratch* scratch);

}  // namespace raywalk::build_lf
