// The bundle adjustment of lens_bundle.h as a Ceres problem.
#pragma once

#include <ceres/problem.h>

#include <vector>

#include "calibrate/lens/lens_bundle.h"
#include "calibrate/lens/track_point.h"

namespace raywalk::calibrate {

// A track with its point and its inlier observations.
struct ActiveTrack {
  int track = 0;
  TrackPoint point{};
  std::vector<int> observations{};
};

// World position of the middle of every line's stations, the centre of the line's rotation.
std::vector<Eigen::Vector3d> line_middles(const BundleInput& input);

// Seen minus fitted, pixels.
Eigen::Vector2d residual_of(const BundleInput& input, const BundleState& state,
                            const Eigen::Vector3d& line_middle_m, const TrackPoint& point,
                            const BundleObservation& observation);

// Adds all observations, in units of `sigma_px` under a Cauchy loss, and the priors. The problem
// changes `state` and `tracks` in place; they must outlive it.
void build_problem(const BundleInput& input, double sigma_px, BundleState* state,
                   std::vector<ActiveTrack>* tracks, ceres::Problem* problem);

}  // namespace raywalk::calibrate
