// Finished maps, written as the volumes of a room.
#pragma once

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"

namespace raywalk::build_lf {

// Writes the finished maps of every line that has some to partial.volumes(). Throws Error and
// Interrupted.
void write_volumes(const Room& room, DepthMethod method, const DepthPlan& plan,
                   const PartialMaps& partial);

}  // namespace raywalk::build_lf
