// The plan of a grid with the exaggerated displacements of its lines.
#pragma once

#include <string>

#include "calibrate/grid/grid_result.h"

namespace raywalk::calibrate {

// An <svg> element: the planned and the estimated position of every station, with the difference
// enlarged until the largest is visible at the stations' spacing.
std::string grid_drawing(const CaptureSet& set, const GridResult& result);

}  // namespace raywalk::calibrate
