// The steps of estimate_grid between reading pictures and writing reports.
#pragma once

#include <vector>

#include "calibrate/grid/crossing_figures.h"
#include "calibrate/grid/estimate_grid.h"

namespace raywalk::calibrate {

// The estimate from given matches, judged. `start` has a pose for every frame; `crossings` are
// those of the set, in any state: one without matches is reported as such. Throws Error as
// estimate_grid does.
GridResult estimate_from_matches(const CaptureSet& set, GridMethod method, const FramePoses& solved,
                                 const FramePoses& start,
                                 const std::vector<CrossingMatches>& crossings);

}  // namespace raywalk::calibrate
