// The whole chain: every step that is not done yet, and the summary.
#pragma once

#include <optional>
#include <ostream>
#include <vector>

#include "calibrate/chain/calibration.h"

namespace raywalk::calibrate {

struct ChainOptions {
  // Counts as not done; none: nothing.
  std::optional<CalibrationStep> redo{};
  // Spacings to compare (keyframe_trade.h); empty: none.
  std::vector<double> compare_keyframes_mm{};
};

// Does the steps in order, leaves out those that are done of the same inputs and options, writes
// calibration.json and index.html and tells on `out` what was done. Throws Error as the steps do
// (what was done is kept, and gone on from by the next call), and, last of all, where the result is
// not to be trusted.
void run_all(Calibration* calibration, const ChainOptions& options, std::ostream& out);

}  // namespace raywalk::calibrate
