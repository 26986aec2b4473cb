// All lines and all stations in one least-squares problem: rail models, solved poses and matches at
// the crossings, each weighted by its variance.
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

// The input of the estimate for one line.
struct RailStart {
  RailFrame frame{};
  RailParameters parameters{};                     // initial values
  std::array<bool, RailParameter::kCount> kept{};  // the estimated ones; the others stay 0
  RailJitter jitter{};                             // of its stations, measured or assumed
  // Standard deviations of the rail's deviation from the plan. Far beyond the errors of placing by
  // hand, they only fix what nothing else determines.
  double offset_prior_m = 0.1;
  double direction_prior_rad = 0.1;
  double rotation_prior_rad = 0.2;
  double twist_prior_rad = 0.2;  // of each coefficient of twist
};

// The inlier matches of one crossing, with the noise and depth of their fit.
struct MatchObservations {
  std::vector<CrossingMatch> matches{};
  double noise_rad = 1e-3;
  InverseDepths depth{};
};

// Standard deviations per component of the error common to the solved poses of a line, at its
// middle; the same again for its increase to the ends.
struct SolvedLineError {
  double position_m = 0.0;
  double rotation_rad = 0.0;
};

struct JointInput {
  std::vector<RailStart> rails{};                  // by line
  FramePoses start{};                              // initial poses of all frames
  std::vector<std::optional<FramePose>> solved{};  // by frame; sigmas are set
  std::vector<MatchObservations> crossings{};
  SolvedLineError solved_error{};
  double scene_m = 1.0;  // distance of the scene, within a factor of a few
};

struct JointEstimate {
  std::vector<RailParameters> rails{};
  // Covariances are relative to the grid as a whole: its common motion, which is unobservable, is
  // excluded.
  std::vector<Eigen::Matrix<double, kRigidParameters, kRigidParameters>> rail_covariance{};
  FramePoses poses{};                        // all frames, sigmas set, origin kSolved or kRail
  std::vector<PoseCovariance> covariance{};  // by frame
  // Of the difference of two frames' poses, one per requested pair.
  std::vector<PoseCovariance> pair_covariance{};
};

struct RelatedFrames {
  int a = 0;
  int b = 0;
};

// Throws Error where the problem has no solution (non-finite input); Interrupted.
JointEstimate estimate_jointly(const CaptureSet& set, const JointInput& input,
                               std::span<const RelatedFrames> pairs);

}  // namespace raywalk::calibrate
