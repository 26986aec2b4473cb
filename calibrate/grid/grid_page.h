// The report of raywalk-calibrate grid.
#pragma once

#include <string>

#include "calibrate/grid/grid_result.h"

namespace raywalk::calibrate {

// A complete HTML page: lines, candidate models, crossings before and after, the plan with
// exaggerated corrections, and the stations' deviations along each line.
std::string grid_page(const CaptureSet& set, const GridResult& result);

}  // namespace raywalk::calibrate
