// The whole chain: runs every step that is not done yet, and writes the summary.
#pragma once

#include <optional>
#include <ostream>
#include <vector>

#include "calibrate/chain/calibration.h"

namespace raywalk::calibrate {

struct ChainOptions {
  // A step to run again even if it is done.
  std::optional<CalibrationStep> redo{};
  // Keyframe spacings whose accuracy and time to compare; empty: no comparison.
  std::vector<double> compare_keyframes_mm{};
};

// Runs the steps in order, skips those that are done with the same inputs and options, writes
// calibration.json and index.html and prints progress, and at the end the figures of every step
// (calibration_report.h) and the verdict, to `out`. Throws Error as the steps do
// (finished steps are kept, and the next call resumes after them), and at the end if the result is
// not trustworthy.
void run_all(Calibration* calibration, const ChainOptions& options, std::ostream& out);

}  // namespace raywalk::calibrate
