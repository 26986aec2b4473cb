// The values of a lens fit, for reports.
#pragma once

#include <string>
#include <vector>

#include "calibrate/lens/calibrate_lens.h"

namespace raywalk::calibrate {

// One parameter of the camera before and after the fit.
struct LensValue {
  std::string key{};  // as in the lens file: "centre_u_px"
  double start = 0.0;
  double fitted = 0.0;
  double sigma = 0.0;  // standard deviation; 0: not fitted
};

std::vector<LensValue> front_values(const LensFit& fit);
std::vector<LensValue> back_values(const LensFit& fit);  // with its attitude
std::vector<LensValue> baseline_values(const LensFit& fit);

// The residuals of a lens in a ring around its axis.
struct ResidualRing {
  bool back = false;
  double off_axis_rad = 0.0;  // in the middle of the ring
  int count = 0;
  double rms_px = 0.0;
  double radial_px = 0.0;  // mean, positive outwards: shows an error of the radial model
};

// Rings of five degrees with at least one residual, by lens and angle.
std::vector<ResidualRing> residual_rings(const LensFit& fit);

}  // namespace raywalk::calibrate
