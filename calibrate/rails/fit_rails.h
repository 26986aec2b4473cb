// The rails of solved stations: smooth curves along which the slider's positions are exact lengths.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/rails/rail_model.h"

namespace raywalk::calibrate {

// Standard deviations per component of the stations' deviations from the rail.
struct RailScatter {
  double along_m = 0.0;
  double across_m = 0.0;  // sideways and up
  double rotation_rad = 0.0;
};

// How stiff a rail is: the standard deviations of its bow, as a share of its half length, and of
// its twist.
inline constexpr double kRailBow = 0.02;
inline constexpr double kRailTwist_rad = 0.05;

struct Rail {
  RailFrame frame{};
  RailParameters parameters{};
  // The parameters that the number of its stations supports; the others are 0.
  std::array<bool, RailParameter::kCount> kept{};
  RailScatter scatter{};
  int stations = 0;  // with a pose
};

// One rail for each line, fitted to the stations with a pose by iteratively reweighted least
// squares with Cauchy's loss: half of a line's stations may contradict the others. The scatter is
// measured about the rail, and at least a ten-thousandth of the stations' spacing; lines of fewer
// than eight stations have at least that of the others. A line without poses has the rail of the
// plan. Throws Interrupted.
std::vector<Rail> fit_rails(const CaptureSet& set, const FramePoses& poses);

// What the rail predicts for a station: origin kRail, sigmas from the scatter.
FramePose pose_on_rail(const CaptureSet& set, const Rail& rail, std::size_t frame);

// A station's deviation from its rail.
struct RailDeviation {
  Eigen::Vector3d off_m{0, 0, 0};       // along, across, up
  Eigen::Vector3d turned_rad{0, 0, 0};  // rotation vector, world axes
};
RailDeviation deviation_of(const CaptureSet& set, const Rail& rail, std::size_t frame,
                           const FramePose& pose);

}  // namespace raywalk::calibrate
