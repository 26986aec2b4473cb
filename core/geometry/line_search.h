// Finds the straight lines along x and z through a set of captured positions. Internal to find_grid
// (grid.h).
#pragma once

#include <span>
#include <vector>

#include "core/geometry/grid.h"
#include "core/geometry/plan_line.h"
#include "core/geometry/station_plan.h"

namespace raywalk {

// The distances that decide which stations form a line, metres, none negative.
struct LineLimits {
  double off_line_m = 0.0;      // from a station to its line
  double same_station_m = 0.0;  // within which two stations count as one; at most twin_m
  // Within which two stations may be the two captured where lines cross, one of each; at most
  // off_line_m.
  double twin_m = 0.0;
};

// A line and the stations (indices) that belong to it.
struct StationGroup {
  PlanLine line;
  std::vector<int> stations;
};

struct FoundLines {
  std::vector<StationGroup> groups;  // no station is in two
  std::vector<int> unplaced;         // stations of no group, in ascending order
};

// Groups the stations into lines. The order of the stations does not matter.
FoundLines find_lines(std::span<const StationPose> stations, const LineLimits& limits);

// The line along `axis` with the most stations that passes near a station; lines may be oblique by
// up to `most_oblique_deg`. Without stations if there is none.
StationGroup line_near(std::span<const StationPose> stations, const LineLimits& limits, int station,
                       LineAxis axis, double most_oblique_deg);

}  // namespace raywalk
