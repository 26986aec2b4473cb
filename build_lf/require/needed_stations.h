// Selects the stations of a line needed for a spacing.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/grid.h"

namespace raywalk::build_lf {

// Increasing indices of stations of `line` with no gap wider than `spacing_m`, except where the
// captured gap is wider. The first, the last and the station nearest to each crossing with another
// line are always kept, because the views of a cell connect there. In between, selection is greedy:
// the next station is the farthest one within `spacing_m`, if possible one of `preferred`
// (increasing; stations with a distance map). An infinite spacing keeps only the fixed stations.
std::vector<int> needed_stations(const Grid& grid, int line, double spacing_m,
                                 std::span<const int> preferred);

}  // namespace raywalk::build_lf
