// All lines and all stations in one least-squares problem: what the rails can do, what solved poses
// say, and what matches at the crossings say, each by its own variance.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/grid/crossing_fit.h"
#include "calibrate/grid/rail_fit.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

// One line as it enters the estimate.
struct RailStart {
  RailFrame frame{};
  RailParameters parameters{};                     // to start from
  std::array<bool, RailParameter::kCount> kept{};  // the others stay 0
  RailJitter jitter{};                             // of its stations, known or assumed
  // How far the rail may lie from where it was planned, standard deviations. Far beyond what
  // placing by hand does, they decide only what nothing else speaks of.
  double offset_prior_m = 0.1;
  double direction_prior_rad = 0.1;
  double rotation_prior_rad = 0.2;
  double twist_prior_rad = 0.2;  // of each coefficient of twist
};

// Matches of one crossing that count, with what their fit found of noise and depth.
struct MatchObservations {
  std::vector<CrossingMatch> matches{};
  double noise_rad = 1e-3;
  InverseDepths depth{};
};

// Standard deviations per component of what the solved poses of a line are wrong by in common, at
// its middle, and by how much more at its ends.
struct SolvedLineError {
  double position_m = 0.0;
  double rotation_rad = 0.0;
};

struct JointInput {
  std::vector<RailStart> rails{};                  // by line
  FramePoses start{};                              // all frames, to start from
  std::vector<std::optional<FramePose>> solved{};  // by frame; sigmas are set
  std::vector<MatchObservations> crossings{};
  SolvedLineError solved_error{};
  double scene_m = 1.0;  // how far things are, within a factor of a few
};

struct JointEstimate {
  std::vector<RailParameters> rails{};
  // Covariances are against the grid as a whole: its common motion, which nothing tells, is not in
  // them.
  std::vector<Eigen::Matrix<double, kRigidParameters, kRigidParameters>> rail_covariance{};
  FramePoses poses{};                        // all frames, sigmas set, origin kSolved or kRail
  std::vector<PoseCovariance> covariance{};  // by frame
  // Of the difference of two frames' poses, one per pair asked for.
  std::vector<PoseCovariance> pair_covariance{};
};

struct RelatedFrames {
  int a = 0;
  int b = 0;
};

// Throws Error where the problem has no solution (numbers that are none); Interrupted.
JointEstimate estimate_jointly(const CaptureSet& set, const JointInput& input,
                               std::span<const RelatedFrames> pairs);

}  // namespace raywalk::calibrate
