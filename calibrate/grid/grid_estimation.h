// The steps of estimate_grid between reading pictures and writing reports.
#pragma once

#include <vector>

#include "calibrate/grid/crossing_figures.h"
#include "calibrate/grid/estimate_grid.h"

namespace raywalk::calibrate {

// The estimate from given matches, with its checks and warnings. `start` has a pose for every
// frame; `crossings` are those of the set, and one without matches gets a warning. Throws Error as
// estimate_grid does.
GridResult estimate_from_matches(const CaptureSet& set, GridMethod method, const FramePoses& solved,
                                 const FramePoses& start,
                                 const std::vector<CrossingMatches>& crossings);

}  // namespace raywalk::calibrate
