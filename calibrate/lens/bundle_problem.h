// The bundle adjustment of lens_bundle.h as a Ceres problem, and the points of its tracks.
#pragma once

#include <ceres/problem.h>

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "calibrate/lens/lens_bundle.h"

namespace raywalk::calibrate {

// The point `from_m` + `direction` / inverse_distance, the direction being
//   axis + right a + up b, with a, b and the inverse distance in `value`.
// The inverse distance also represents points at infinity: a ray from p to the point runs along
// direction - inverse_distance (p - from_m), which is linear in all three.
struct TrackPoint {
  Eigen::Vector3d from_m{0, 0, 0};
  Eigen::Vector3d axis{0, 0, 1};
  Eigen::Vector3d right{1, 0, 0};
  Eigen::Vector3d up{0, 1, 0};
  Eigen::Vector3d value{0, 0, 0};  // a, b, inverse distance in 1 / m

  Eigen::Vector3d ray_from(const Eigen::Vector3d& position_m) const {
    return axis + value[0] * right + value[1] * up - value[2] * (position_m - from_m);
  }
};

// The point with the least squared angles to the rays, anchored at the first of at least two rays;
// nullopt if it is behind a ray or the rays do not determine it.
std::optional<TrackPoint> triangulate(std::span<const ViewRay> rays);

// The point of a track and the observations that agree with it.
struct ActiveTrack {
  TrackPoint point{};
  BundleTrack seen{};
};

// World position of the middle of every line's stations, the centre of the line's rotation.
std::vector<Eigen::Vector3d> line_middles(const BundleInput& input);

// Seen minus fitted, pixels. `line_middle_m` is that of the station's line.
Eigen::Vector2d residual_of(const BundleInput& input, const BundleState& state,
                            const Eigen::Vector3d& line_middle_m, const TrackPoint& point,
                            const BundleObservation& observation);

// Adds all observations, in units of `sigma_px` under a Cauchy loss, and the priors. The problem
// changes `state` and `tracks` in place; they must outlive it.
void build_problem(const BundleInput& input, double sigma_px, BundleState* state,
                   std::vector<ActiveTrack>* tracks, ceres::Problem* problem);

}  // namespace raywalk::calibrate
