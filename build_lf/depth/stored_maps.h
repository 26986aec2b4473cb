// Writes finished maps as distance volumes.
#pragma once

#include "build_lf/depth/contradictions.h"
#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"

namespace raywalk::build_lf {

// Writes the finished maps of every line that has any to partial.volumes(), and what views leave
// out of the line's stations. Throws Error if a map is damaged or cannot be written, and
// Interrupted.
void write_volumes(const Room& room, DepthMethod method, const DepthPlan& plan,
                   const PartialMaps& partial, const Contradictions& contradictions);

}  // namespace raywalk::build_lf
