// The reference lengths of a grid, which the estimate and its checks share.
#pragma once

#include "calibrate/base/capture_set.h"
#include "calibrate/grid/crossing_fit.h"

namespace raywalk::calibrate {

// Reference lengths of a grid, which make all thresholds independent of its size.
struct GridScale {
  double spacing_m = 0.025;  // median distance between neighbouring stations
  double length_m = 1.0;     // median length of the lines
  double pixel_rad = 1e-3;   // of the panoramas
};
GridScale grid_scale(const CaptureSet& set);
CrossingFitScale fit_scale(const GridScale& scale);

}  // namespace raywalk::calibrate
