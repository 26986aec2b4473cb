// Semi-global matching (Hirschmueller 2008): the distances that fit what is seen and change little
// from pixel to pixel, except where the picture has an edge.
#pragma once

#include "build_lf/depth/plane_sweep.h"

namespace raywalk::build_lf {

// Memory that is kept from one call to the next: 2 bytes per pixel and layer.
struct SemiGlobalScratch {
  std::vector<std::uint16_t> sum;
};

// Picks the inverse distance of every pixel of a swept reference: the layer with the least sum of
// path costs from eight directions, interpolated by a parabola. Confidence says how much better it
// is than the best layer elsewhere; 0 where nothing could be compared. Paths close around the
// sphere: along a row through the seam, along a column over the poles.
InverseDistanceMap regularise(const CostVolume& volume, const SweepReference& reference,
                              SemiGlobalScratch* scratch);

}  // namespace raywalk::build_lf
