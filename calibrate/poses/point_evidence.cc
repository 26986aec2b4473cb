#include "calibrate/poses/point_evidence.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "calibrate/base/cauchy_loss.h"
#include "calibrate/base/rotation.h"

namespace raywalk::calibrate {

double error_px(const PointObservation& observation, const FramePose& pose,
                const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d seen =
      pose.world_from_camera.transpose() * (point_m - pose.position_m) - observation.centre_m;
  return kResidualPx_per_rad *
         std::atan2(seen.cross(observation.bearing).norm(), seen.dot(observation.bearing));
}

LinearObservation linearised(const PointObservation& observation, const FramePose& pose,
                             const Eigen::Vector3d& point_m, double noise_px, double unit_m) {
  const Eigen::Matrix3d camera_from_world = pose.world_from_camera.transpose();
  const Eigen::Vector3d in_camera = camera_from_world * (point_m - pose.position_m);
  const Eigen::Vector3d seen = in_camera - observation.centre_m;
  const Eigen::Vector3d predicted = seen.normalized();
  // The Cauchy loss weights an error e by 1 / (1 + (e / width)^2).
  const double share = error_px(observation, pose, point_m) / (kCauchySigmas * noise_px);
  const Eigen::Matrix<double, 2, 3> across = axes_across(observation.bearing) *
                                             kResidualPx_per_rad /
                                             (noise_px * std::sqrt(1.0 + share * share));
  const Eigen::Matrix<double, 2, 3> by_seen =
      across * (Eigen::Matrix3d::Identity() - predicted * predicted.transpose()) / seen.norm();
  LinearObservation linear{.by_point = by_seen * camera_from_world, .error = across * predicted};
  // A small rotation w takes what the camera sees to seen - w x seen.
  linear.by_pose.leftCols<3>() = by_seen * cross_matrix(in_camera);
  linear.by_pose.rightCols<3>() = -unit_m * linear.by_point;
  return linear;
}

PointEvidence::PointEvidence(std::vector<LinearObservation> observations)
    : observations_(std::move(observations)) {
  Eigen::Matrix3d of_point = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient(0, 0, 0);
  for (const LinearObservation& one : observations_) {
    of_point += one.by_point.transpose() * one.by_point;
    gradient += one.by_point.transpose() * one.error;
  }
  // For a point so far away that its distance is undetermined.
  of_point += 1e-12 * of_point.trace() * Eigen::Matrix3d::Identity();
  point_covariance_ = of_point.inverse();
  point_step_m_ = -point_covariance_ * gradient;
  // What is left of the errors with the point where the observations want it.
  for (LinearObservation& one : observations_) one.error += one.by_point * point_step_m_;
}

Matrix6 PointEvidence::normal(std::size_t i, std::size_t j) const {
  const LinearObservation &a = observations_[i], &b = observations_[j];
  Eigen::Matrix2d independent = -a.by_point * point_covariance_ * b.by_point.transpose();
  if (i == j) independent += Eigen::Matrix2d::Identity();
  return a.by_pose.transpose() * independent * b.by_pose;
}

Vector6 PointEvidence::gradient(std::size_t i) const {
  return observations_[i].by_pose.transpose() * observations_[i].error;
}

double curvature_share(const std::vector<double>& errors_px, double noise_px) {
  double curvature = 0.0;
  double weights = 0.0;
  for (const double error : errors_px) {
    const double share = error / (kCauchySigmas * noise_px);
    const double weight = 1.0 / (1.0 + share * share);
    curvature += 0.5 * (weight + weight * weight * (1.0 - share * share));
    weights += weight;
  }
  return curvature / weights;
}

}  // namespace raywalk::calibrate
