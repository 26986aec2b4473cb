// By how much two lines' panoramas disagree where the lines cross, from matches alone.
#pragma once

#include <Eigen/Core>
#include <span>

#include "calibrate/base/frame_poses.h"
#include "calibrate/grid/crossing_matches.h"
#include "calibrate/grid/match_residual.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

// Position (m), then rotation (rad), world axes.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

// The rigid motion of the frames of the line along x, relative to those of the line along z, that
// makes the matches agree: a rotation by `rotation_rad` (a rotation vector, world axes) about
// `pivot_m`, then a translation by `motion_m`.
struct CrossingFit {
  Eigen::Vector3d rotation_rad{0, 0, 0};
  Eigen::Vector3d motion_m{0, 0, 0};
  Eigen::Vector3d pivot_m{0, 0, 0};
  PoseCovariance covariance = PoseCovariance::Zero();
  double noise_rad = 0.0;      // sigma of one direction, from the matches' scatter about the fit
  InverseDepths depth{};       // of the matched points
  std::vector<bool> inlier{};  // by match
  int inliers = 0;
};

// The scales of a crossing's unknowns.
struct CrossingFitScale {
  double scene_m = 1.0;     // distance of the scene, within a factor of a few: the lines' length
  double motion_m = 0.1;    // prior standard deviation of the lines' relative displacement
  double pixel_rad = 1e-3;  // of the panoramas
};
CrossingFitScale fit_scale(const GridScale& scale);

// `poses` hold the frames of the matches. The fit starts from the rotation of a RANSAC consensus,
// so the poses may be wrong by as much as matching allows (kMatchGate_deg). Fewer than 8 matches
// give a fit without inliers.
CrossingFit fit_crossing(std::span<const CrossingMatch> matches, const FramePoses& poses,
                         const CrossingFitScale& scale);

// A ray of a match in the world.
WorldRay world_ray(const FramePose& pose, const MatchRay& ray);

// Distance of a match from its epipolar line after the fit's motion, radians.
double epipolar_error_rad(const CrossingMatch& match, const FramePoses& poses,
                          const CrossingFit& fit);

}  // namespace raywalk::calibrate
