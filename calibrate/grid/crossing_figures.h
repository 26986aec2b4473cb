// The figures of each crossing, and whether the estimate is trustworthy there.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibrate/grid/crossing_fit.h"
#include "calibrate/grid/grid_result.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

// The difference of two estimates of the lines' relative pose at a crossing, and the difference
// expected from scatter alone.
struct SplitDifference {
  double position_m = 0.0;
  double position_expected_m = 0.0;
  double rotation_rad = 0.0;
  double rotation_expected_rad = 0.0;
};

struct CrossingEvidence {
  const CrossingMatches* matches = nullptr;
  int used_matches = 0;  // inliers of the estimate
  double noise_rad = 0.0;
  PoseCovariance covariance = PoseCovariance::Zero();  // of the nearest stations' relative pose
  SplitDifference split{};
};

// Measures a crossing at the poses before and after, by the held-out matches alone, and adds its
// warnings.
CrossingFigures crossing_figures(const CaptureSet& set, const CrossingEvidence& evidence,
                                 const FramePoses& before, const FramePoses& after,
                                 const GridScale& scale);

}  // namespace raywalk::calibrate
