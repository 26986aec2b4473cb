// The rail of one line, fitted to the solved poses of its stations alone: which model the data
// speaks for, how far stations scatter about it, and which solved poses contradict it.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibrate/grid/grid_result.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

// A station's solved pose.
struct RailSample {
  int frame = 0;
  double rail_m = 0.0;
  Eigen::Vector3d position_m{0, 0, 0};
  // What turns the planned attitude into the solved one, as a matrix in world axes.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double position_sigma_m = 0.0;
  double rotation_sigma_rad = 0.0;
  // How well the pose is supported against others of its set: false where it rests on much fewer
  // observations or fits them much worse than the median.
  bool well_supported = false;
};

// Standard deviations per component of what stations deviate from the rail by.
struct RailJitter {
  double along_m = 0.0;
  double across_m = 0.0;  // and up
  double rotation_rad = 0.0;
};

struct RailFit {
  RailParameters parameters{};
  // Which of the parameters the data speaks for; the others are 0.
  std::array<bool, RailParameter::kCount> kept{};
  RailJitter jitter{};
  std::vector<RailModelScore> position_models{}, rotation_models{};
  std::vector<bool> rejected{};  // by sample
};

// Fits by iteratively reweighted least squares and compares models by the Bayesian information
// criterion over the samples that were not rejected. A sample is rejected where it is more than
// six robust standard deviations off, and, where it is well supported, more than half a
// `spacing_m`: a bump of the rail is as rare as a wrong pose, and only the picture can tell which
// it was. At least one sample; with few of them the model is the planned line moved.
RailFit fit_rail(const RailFrame& frame, std::span<const RailSample> samples, double spacing_m);

}  // namespace raywalk::calibrate
