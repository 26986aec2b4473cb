// Settles which line owns the stations captured where two lines cross. A step of find_grid
// (grid.h); nothing else needs it.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/line_search.h"

namespace raywalk {

// Reassigns the stations at every crossing and sorts each group's stations along its line.
// - Two stations: one for each line. The capture order tells which: the slider visits a line's
// stations
//   one after the other, so a station belongs with its neighbours in the list, or in the file
//   names, whichever order follows the lines more.
// - One station: the line that would otherwise have the larger hole, measured in its own spacing.
// Throws Error when more than two stations lie at a crossing: the tolerance does not tell them
// apart.
void assign_crossing_stations(std::span<const StationPose> stations, double tolerance_m,
                              std::vector<StationGroup>* groups);

}  // namespace raywalk
