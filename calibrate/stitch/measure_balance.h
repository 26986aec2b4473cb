// Measures the balance of a camera's lenses, once for all frames of a capture.
#pragma once

#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/stitch/balance_fit.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

struct BalanceReport {
  BalanceFit fit{};
  int overlap_ratios = 0;  // between both lenses in one frame
  int motion_ratios = 0;   // between two frames in one lens
  int frames = 0;          // used
  // Over the frames, medians of SeamFigures: absolute step, correlation.
  double step_before_levels = 0.0;
  double step_after_levels = 0.0;
  double correlation = 0.0;
  std::vector<std::string> warnings{};
};

// Uses a few dozen frames, in groups of neighbours, spread over all lines. With `balance` false
// only the figures are measured and the balance is the identity. Throws Error as
// read_frame_pictures does; Interrupted.
BalanceReport measure_balance(const CaptureSet& set, const DualFisheyeCamera& camera, bool balance);

}  // namespace raywalk::calibrate
