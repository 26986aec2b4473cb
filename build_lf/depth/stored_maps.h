// Writes finished maps as distance volumes.
#pragma once

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"

namespace raywalk::build_lf {

// Writes the finished maps of every line that has any to partial.volumes(). Throws Error if a map
// is damaged or cannot be written, and Interrupted.
void write_volumes(const Room& room, DepthMethod method, const DepthPlan& plan,
                   const PartialMaps& partial);

}  // namespace raywalk::build_lf
