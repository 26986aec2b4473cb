// What a calibration achieved, in numbers for the terminal.
#pragma once

#include <string>

#include "calibrate/chain/calibration.h"

namespace raywalk::calibrate {

// The figures of a step's last run, read from its results in OUT, as one line:
// "36 of 36 stations posed, residual 0.54 px, positions to 0.19 mm". Empty for a step that has
// none. Throws Error if a result is missing or damaged.
std::string step_numbers(const Calibration& calibration, CalibrationStep step);

}  // namespace raywalk::calibrate
