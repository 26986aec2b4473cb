// Says why a station belongs to no line. Internal to find_grid (grid.h).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/geometry/line_search.h"

namespace raywalk {

// "front_000.jpg (poses.csv:2)", for errors.
std::string name_of(const StationPose& station);

// Throws Error for the first of the stations that are of no line (at least one), `others` being the
// lines that were found without them. The first of these reasons that applies:
// - it has the position of another station;
// - it is on a line that is more oblique than allowed;
// - it is beside one of the lines, farther than the tolerance;
// - no line along x or z through it has another station.
[[noreturn]] void throw_unplaced(std::span<const StationPose> stations, const LineLimits& limits,
                                 const std::vector<StationGroup>& others,
                                 std::span<const int> unplaced);

// Throws Error if a line lies so close beside a longer one that its stations are rather too far
// beside that one: within twice the tolerance.
void require_lines_apart(std::span<const StationPose> stations, const LineLimits& limits,
                         const std::vector<StationGroup>& lines);

}  // namespace raywalk
