// The reprojection residual of a scene point in a panorama.
#pragma once

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

// Residuals are in pixels of a panorama of this width, whatever the width of those matched.
inline constexpr double kResidualWidth_px = 4096.0;
inline constexpr double kResidualPx_per_rad = kResidualWidth_px / kTwoPi;

// A scene point seen in a panorama. Camera's frame.
struct PointObservation {
  int frame = 0;                      // index into the poses
  int point = 0;                      // index into the points
  Eigen::Vector3d bearing{0, 0, 1};   // unit vector
  Eigen::Vector3d centre_m{0, 0, 0};  // centre of projection: the lens's position
};

// Parameters: six of the pose (a rotation vector w and the position t, so that world_from_camera =
// reference * exp(w)), three of the point. Two residuals: the sine of the angle between the
// predicted and the observed bearing, along two axes across the bearing, times kResidualPx_per_rad:
// pixels for small angles, bounded for large ones.
std::unique_ptr<ceres::CostFunction> bearing_cost(const PointObservation& observation,
                                                  const Eigen::Matrix3d& reference);

// The norm of the residual at w = 0.
double bearing_error_px(const PointObservation& observation,
                        const Eigen::Matrix3d& world_from_camera, const Eigen::Vector3d& position_m,
                        const Eigen::Vector3d& point_m);

}  // namespace raywalk::calibrate
