// Finds the straight lines along x and z through a set of captured positions. Internal to find_grid
// (grid.h).
#pragma once

#include <span>
#include <vector>

#include "core/geometry/line_near.h"
#include "core/geometry/station_plan.h"

namespace raywalk {

struct FoundLines {
  std::vector<StationGroup> groups;  // no station is in two
  std::vector<int> unplaced;         // stations of no group, in ascending order
};

// Groups the stations into lines. The order of the stations does not matter.
FoundLines find_lines(std::span<const StationPose> stations, const LineLimits& limits);

}  // namespace raywalk
