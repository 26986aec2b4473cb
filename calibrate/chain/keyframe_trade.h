// The trade-off between accuracy and time of fewer keyframes: the poses solved again with several
// keyframe spacings.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "calibrate/chain/calibration.h"

namespace raywalk::calibrate {

// Runs the steps poses and grid for each spacing in OUT/trade/, densest first, and writes
// OUT/trade.json, which is read instead if it has the same inputs. Returns its content, a list of
// what each spacing gives: {"keyframes_mm" (0: every station), "keyframes", "seconds" of both
// steps, "trustworthy", "largest_mm", "largest_deg", "median_mm", "median_deg"}.
nlohmann::ordered_json compare_keyframes(Calibration* calibration, std::vector<double> spacings_mm);

}  // namespace raywalk::calibrate
