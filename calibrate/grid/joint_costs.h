// The residuals of the joint estimate (joint_estimate.h), each divided by its standard deviation. A
// station's unknowns are its position and a rotation vector `turn` applied to a reference attitude.
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "calibrate/base/frame_poses.h"
#include "calibrate/grid/match_residual.h"
#include "calibrate/grid/rail_fit.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

// The rotation vector of exp(turn) * reference * exp(expected)^T, computed with quaternions, whose
// automatic derivatives exist at zero.
template <typename T>
void rotation_difference(const T* turn, const Eigen::Matrix3d& reference, const T* expected,
                         T* difference) {
  T turned[4], middle[4], back[4], product[4], result[4];
  ceres::AngleAxisToQuaternion(turn, turned);
  const Eigen::Quaterniond fixed(reference);
  middle[0] = T(fixed.w());
  middle[1] = T(fixed.x());
  middle[2] = T(fixed.y());
  middle[3] = T(fixed.z());
  const T opposite[3] = {-expected[0], -expected[1], -expected[2]};
  ceres::AngleAxisToQuaternion(opposite, back);
  ceres::QuaternionProduct(turned, middle, product);
  ceres::QuaternionProduct(product, back, result);
  ceres::QuaternionToAngleAxis(result, difference);
}

// A station's deviation from its rail, in the rail's axes.
struct RailCost {
  RailFrame frame;
  double rail_m;
  RailJitter jitter;
  Eigen::Matrix3d turn_reference;  // reference * planned attitude^T

  template <typename T>
  bool operator()(const T* position, const T* turn, const T* rail, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const RailAxes<T> axes =
        rail_axes(frame.axis, rail[RailParameter::kHeading], rail[RailParameter::kTilt]);
    const Vector off = Eigen::Map<const Vector>(position) - rail_position(frame, rail, rail_m);
    residual[0] = off.dot(axes.direction) / jitter.along_m;
    residual[1] = off.dot(axes.across) / jitter.across_m;
    residual[2] = off.dot(axes.up) / jitter.across_m;
    const Vector expected = rail_rotation(frame, rail, rail_m);
    rotation_difference(turn, turn_reference, expected.data(), residual + 3);
    for (int i = 3; i < 6; ++i) residual[i] /= jitter.rotation_rad;
    return true;
  }
};

// The common error of a line's solved poses: position and rotation at its middle, then their
// increase to the end at u = 1.
inline constexpr int kLineErrorParameters = 12;

struct SolvedCost {
  FramePose solved;
  Eigen::Matrix3d turn_reference;  // reference * solved attitude^T
  double u;

  template <typename T>
  bool operator()(const T* position, const T* turn, const T* error, T* residual) const {
    const T none[3] = {T(0), T(0), T(0)};
    rotation_difference(turn, turn_reference, none, residual + 3);
    for (int i = 0; i < 3; ++i) {
      const T moved = error[i] + u * error[6 + i];
      const T turned = error[3 + i] + u * error[9 + i];
      residual[i] =
          (position[i] + moved - solved.position_m[i]) / (1e-3 * solved.position_sigma_mm);
      residual[3 + i] =
          (residual[3 + i] + turned) / radians_from_degrees(solved.rotation_sigma_deg);
    }
    return true;
  }
};

struct LineErrorPriorCost {
  double position_m;
  double rotation_rad;

  template <typename T>
  bool operator()(const T* error, T* residual) const {
    for (int i = 0; i < kLineErrorParameters; ++i) {
      residual[i] = error[i] / (i % 6 < 3 ? position_m : rotation_rad);
    }
    return true;
  }
};

// The residual of match_residual.h as a function of both stations' poses.
struct MatchCost {
  Eigen::Vector3d x_origin, x_bearing, z_origin, z_bearing;  // in the references' world axes
  Whitening whitening;

  template <typename T>
  bool operator()(const T* x_position, const T* x_turn, const T* z_position, const T* z_turn,
                  const T* mean_inverse_distance, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Vector from_x = Eigen::Map<const Vector>(x_position) + rotated(x_turn, x_origin);
    const Vector from_z = Eigen::Map<const Vector>(z_position) + rotated(z_turn, z_origin);
    Eigen::Map<Eigen::Matrix<T, 2, 1>> result(residual);
    result = whitening.cast<T>() * direction_difference<T>(from_x, rotated(x_turn, x_bearing),
                                                           from_z, rotated(z_turn, z_bearing),
                                                           mean_inverse_distance[0]);
    return true;
  }
};

struct RailPriorCost {
  RailParameters weight;  // 1 / sigma

  template <typename T>
  bool operator()(const T* rail, T* residual) const {
    for (size_t i = 0; i < weight.size(); ++i) residual[i] = rail[i] * weight[i];
    return true;
  }
};

}  // namespace raywalk::calibrate
