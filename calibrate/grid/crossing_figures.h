// The figures of each crossing, and whether they let the estimate be trusted.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibrate/grid/crossing_fit.h"
#include "calibrate/grid/grid_result.h"

namespace raywalk::calibrate {

// What lengths of a grid are measured by, so that a grid of any size is judged alike.
struct GridScale {
  double spacing_m = 0.025;  // median distance between neighbouring stations
  double length_m = 1.0;     // median length of the lines
  double pixel_rad = 1e-3;   // of the panoramas
};
GridScale grid_scale(const CaptureSet& set);
CrossingFitScale fit_scale(const GridScale& scale);

// A difference of two estimates of the lines' relative pose at a crossing, and what scatter alone
// would make of it.
struct SplitDifference {
  double position_m = 0.0;
  double position_expected_m = 0.0;
  double rotation_rad = 0.0;
  double rotation_expected_rad = 0.0;
};

struct CrossingEvidence {
  const CrossingMatches* matches = nullptr;
  int used_matches = 0;  // that the estimate kept
  double noise_rad = 0.0;
  PoseCovariance covariance = PoseCovariance::Zero();  // of the nearest stations' relative pose
  SplitDifference split{};
};

// Measures a crossing at the poses before and after, by the held-out matches alone, and judges it.
CrossingFigures crossing_figures(const CaptureSet& set, const CrossingEvidence& evidence,
                                 const FramePoses& before, const FramePoses& after,
                                 const GridScale& scale);

// Pixels of a panorama 4096 wide that an angle spans.
double pixels_at_4096(double angle_rad);

}  // namespace raywalk::calibrate
