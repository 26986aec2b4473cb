// Finished maps: read from where they were made, and written as the volumes of a room.
#pragma once

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"

namespace raywalk {

// The stage of maps that are finished.
inline constexpr const char* kFinalStage = "final";

// A finished map. Throws Error if it is damaged.
InverseDistanceMap finished_map(const PartialMaps& partial, const DepthPlan& plan,
                                const SweepReference& reference);

// Writes the finished maps of every line that has some to partial.volumes(). Throws Error and
// Interrupted.
void write_volumes(const Room& room, DepthMethod method, const DepthPlan& plan,
                   const PartialMaps& partial);

}  // namespace raywalk
