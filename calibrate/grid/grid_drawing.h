// The plan of a grid with what its lines were moved by, exaggerated.
#pragma once

#include <string>

#include "calibrate/grid/grid_result.h"

namespace raywalk::calibrate {

// An <svg> element: every station where it was planned, and where the estimate has it with the
// difference enlarged until the largest is a good part of the stations' spacing.
std::string grid_drawing(const CaptureSet& set, const GridResult& result);

}  // namespace raywalk::calibrate
