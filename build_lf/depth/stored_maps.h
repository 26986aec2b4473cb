// Writes finished maps as distance volumes.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "build_lf/depth/contradictions.h"
#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"

namespace raywalk::build_lf {

// Writes the finished maps of lines that have any to partial.volumes(), and what views leave out of
// each line's stations, which `contradictions_of` tells. Throws Error if a map is damaged or cannot
// be written, and Interrupted.
void write_volumes(const Room& room, DepthMethod method, const DepthPlan& plan,
                   const PartialMaps& partial, const std::vector<std::size_t>& lines,
                   const std::function<Contradictions(int line)>& contradictions_of);

// Removes all other volumes from partial.volumes(): an interrupted run can have left there what it
// replaced.
void remove_other_volumes(const Room& room, const DepthPlan& plan, const PartialMaps& partial);

}  // namespace raywalk::build_lf
