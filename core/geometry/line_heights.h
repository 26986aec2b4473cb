// The heights of a line's stations. Internal to find_grid (grid.h).
#pragma once

#include <span>
#include <string>

#include "core/geometry/grid.h"

namespace raywalk {

// Steepest climb of a line: a road of 10 %.
inline constexpr double kMaxClimbDeg = 6.0;

// Throws Error naming a station whose height does not fit those of the line: more than
// `tolerance_m` above or below the straight line of least squares, unless the line goes up and down
// hill. What that line is uncertain by is allowed on top, if some other line is within tolerance of
// all stations. On a hill
// every station is within the tolerance of the straight line between its neighbours, and no two
// neighbours differ by more than the steepest climb and the tolerance. Throws Error too if the line
// as a whole climbs more steeply. `names` are the stations' for errors.
void check_heights(const Line& line, std::span<const std::string> names, double tolerance_m);

}  // namespace raywalk
