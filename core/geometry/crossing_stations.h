// Assigns the stations captured where two lines cross to one of the lines. Internal to find_grid
// (grid.h).
#pragma once

#include <span>
#include <vector>

#include "core/geometry/line_search.h"

namespace raywalk {

// Reassigns the stations at every crossing, those within tolerance of both lines, and sorts each
// group's stations along its line.
// - One station: it goes to the line that would otherwise have the larger gap, relative to its
//   spacing.
// - Two stations: one per line. The capture order decides: the slider visits a line's stations one
//   after the other, so a station belongs with its neighbours in the list or in the file names,
//   whichever order follows the lines better. If that puts both firmly on one line, they are two
//   neighbours of it.
// - More, where the tolerance is as large as the spacing: each goes where the capture order or, if
//   this says nothing, the distance puts it.
// Throws Error when more than two stations count as one at a crossing, and when a line has fewer
// than two stations of its own.
void assign_crossing_stations(std::span<const StationPose> stations, const LineLimits& limits,
                              std::vector<StationGroup>* groups);

}  // namespace raywalk
