// Selects the stations needed for a spacing.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/grid.h"
#include "core/room/room.h"

namespace raywalk {

// Increasing indices of stations of `line` with no gap wider than `spacing_m`, except where the
// captured gap is wider. The first, the last and the station nearest to each crossing with another
// line are always kept, because the views of a cell connect there. In between, selection is greedy:
// the next station is the farthest one within `spacing_m`, if possible one of `preferred`
// (increasing; stations with a distance map). An infinite spacing keeps only the fixed stations.
std::vector<int> needed_stations(const Grid& grid, int line, double spacing_m,
                                 std::span<const int> preferred);

enum class Preferred { kAny, kWithDistances };

// The same of all lines of a room; kWithDistances prefers the stations with a distance map.
KeptStations needed_stations(const Room& room, double spacing_m,
                             Preferred preferred = Preferred::kAny);

}  // namespace raywalk
