// Assigns the stations captured where two lines cross to one of the lines. Internal to find_grid
// (grid.h).
#pragma once

#include <span>
#include <vector>

#include "core/geometry/line_search.h"

namespace raywalk {

// Reassigns the stations at every crossing and sorts each group's stations along its line.
// - Two stations: one per line. The capture order decides: the slider visits a line's stations one
//   after the other, so a station belongs with its neighbours in the list or in the file names,
//   whichever order follows the lines better.
// - One station: it goes to the line that would otherwise have the larger gap, relative to its
//   spacing.
// Throws Error when more than two stations lie at a crossing: the tolerance cannot separate them.
void assign_crossing_stations(std::span<const StationPose> stations, double tolerance_m,
                              std::vector<StationGroup>* groups);

}  // namespace raywalk
