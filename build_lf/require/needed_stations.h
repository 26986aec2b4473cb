// Which stations of a line suffice for a spacing.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/grid.h"

namespace raywalk::build_lf {

// Indices, increasing, of stations of `line` that leave no gap wider than `spacing_m`, except where
// the line itself has none between. The first, the last and the station nearest to each crossing
// with another line are always kept: the views of a cell connect there. From each the farthest
// within reach comes next, of those in `preferred` (increasing; stations with a distance map) if
// any is within reach. An infinite spacing keeps the fixed stations alone.
std::vector<int> needed_stations(const Grid& grid, int line, double spacing_m,
                                 std::span<const int> preferred);

}  // namespace raywalk::build_lf
