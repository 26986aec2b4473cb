// What the observations of one scene point tell of the poses that see it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/seen_points.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

// Residuals are in pixels of a panorama of this width, whatever the width of those matched.
inline constexpr double kResidualWidth_px = 4096.0;
inline constexpr double kResidualPx_per_rad = kResidualWidth_px / kTwoPi;

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// The angle between the predicted and the observed bearing, pixels of a panorama 4096 wide.
double error_px(const PointObservation& observation, const FramePose& pose,
                const Eigen::Vector3d& point_m);

// The error of an observation across its bearing, and its derivatives by the pose (a rotation
// vector in the camera's frame, then the position in units of `unit_m`) and by the point (metres).
// In standard deviations, weighted by Cauchy's loss.
struct LinearObservation {
  std::size_t pose = 0;  // the caller's index
  Eigen::Matrix<double, 2, 6> by_pose{};
  Eigen::Matrix<double, 2, 3> by_point{};
  Eigen::Vector2d error{};
};

LinearObservation linearised(const PointObservation& observation, const FramePose& pose,
                             const Eigen::Vector3d& point_m, double noise_px, double unit_m);

// The evidence with the point itself eliminated (Schur complement).
class PointEvidence {
 public:
  explicit PointEvidence(std::vector<LinearObservation> observations);

  std::size_t size() const { return observations_.size(); }
  std::size_t pose(std::size_t i) const { return observations_[i].pose; }
  // The share of two observations in the normal equations of the poses, and the gradient of one.
  Matrix6 normal(std::size_t i, std::size_t j) const;
  Vector6 gradient(std::size_t i) const;
  // The step from the point to where the observations want it.
  const Eigen::Vector3d& point_step_m() const { return point_step_m_; }

 private:
  std::vector<LinearObservation> observations_;
  Eigen::Matrix3d point_covariance_;
  Eigen::Vector3d point_step_m_;
};

// The factor by which the weights of Cauchy's loss overstate the information of observations with
// these errors. The information is the curvature of the loss: w^2 (1 - (e / c)^2) along an error e
// and w across it, with the weight w = 1 / (1 + (e / c)^2). The factor is the mean of both over the
// mean weight (Huber 1981, section 7.6).
double curvature_share(const std::vector<double>& errors_px, double noise_px);

}  // namespace raywalk::calibrate
