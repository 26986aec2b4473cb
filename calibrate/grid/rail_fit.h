// The rail of one line, fitted to the solved poses of its stations alone: the model that the data
// support, the stations' scatter about it, and the solved poses that are outliers.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

// A station's solved pose.
struct RailSample {
  int frame = 0;
  double rail_m = 0.0;
  Eigen::Vector3d position_m{0, 0, 0};
  // From the planned attitude to the solved one, in world axes.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double position_sigma_m = 0.0;
  double rotation_sigma_rad = 0.0;
  // False if the pose has far fewer observations or a far larger residual than the median pose.
  bool well_supported = false;
};

// Standard deviations per component of the stations' deviations from the rail.
struct RailJitter {
  double along_m = 0.0;
  double across_m = 0.0;  // sideways and up
  double rotation_rad = 0.0;
};

struct RailFit {
  RailParameters parameters{};
  // The parameters of the selected models; the others are 0.
  std::array<bool, RailParameter::kCount> kept{};
  RailJitter jitter{};
  std::vector<RailModelScore> position_models{}, rotation_models{};
  std::vector<bool> rejected{};  // by sample
};

// Fits by iteratively reweighted least squares and selects models by the Bayesian information
// criterion over the inliers. A sample is rejected if it is more than six robust standard
// deviations off; a well-supported one only if it is also more than half a `spacing_m` off, as it
// may show a real bump of the rail. At least one sample; with few samples the model is the planned
// line, translated and rotated.
RailFit fit_rail(const RailFrame& frame, std::span<const RailSample> samples, double spacing_m);

}  // namespace raywalk::calibrate
