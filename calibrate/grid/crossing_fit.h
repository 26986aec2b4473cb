// By how much two lines' panoramas disagree where the lines cross, from matches alone.
#pragma once

#include <Eigen/Core>
#include <span>

#include "calibrate/base/frame_poses.h"
#include "calibrate/grid/crossing_matches.h"
#include "calibrate/grid/match_residual.h"

namespace raywalk::calibrate {

// Position (m), then rotation (rad), world axes.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

// The motion of the frames of the line along x, as one rigid body against those of the line along
// z, that brings the matches together: turned by `rotation_rad` (a rotation vector, world axes)
// about `pivot_m` and then moved.
struct CrossingFit {
  Eigen::Vector3d rotation_rad{0, 0, 0};
  Eigen::Vector3d motion_m{0, 0, 0};
  Eigen::Vector3d pivot_m{0, 0, 0};
  PoseCovariance covariance = PoseCovariance::Zero();
  double noise_rad = 0.0;      // of one direction, as the matches scatter about the fit
  InverseDepths depth{};       // of what the matches show
  std::vector<bool> inlier{};  // by match
  int inliers = 0;
};

// What a crossing's matches can be looked for at most and what is known of it.
struct CrossingFitScale {
  double scene_m = 1.0;     // how far things are, within a factor of a few: the length of the lines
  double motion_m = 0.1;    // standard deviation that the lines' relative placing is known to
  double pixel_rad = 1e-3;  // of the panoramas
};

// `poses` hold the frames of the matches. Starts from the rotation that most matches agree on, so
// the poses may be wrong by as much as matching allowed. Fewer than 8 matches give a fit without
// inliers.
CrossingFit fit_crossing(std::span<const CrossingMatch> matches, const FramePoses& poses,
                         const CrossingFitScale& scale);

// Rays of a match in the world at given poses.
WorldRay world_ray(const FramePose& pose, const MatchRay& ray);

// Distance of each match from its epipolar line, radians of one direction.
double epipolar_error_rad(const CrossingMatch& match, const FramePoses& poses,
                          const CrossingFit& fit);

}  // namespace raywalk::calibrate
