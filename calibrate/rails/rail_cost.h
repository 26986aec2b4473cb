// Ceres residuals of stations and their rail, in standard deviations.
#pragma once

#include <ceres/problem.h>
#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "calibrate/rails/fit_rails.h"
#include "calibrate/rails/rail_model.h"

namespace raywalk::calibrate {

// The unknowns of a pose: a rotation vector w, then the position; world_from_camera = reference *
// exp(w).
using PoseParameters = std::array<double, 6>;

// A station's deviation from its rail: along, across and up in the rail's axes, then twice the
// vector part of the quaternion of its rotation from the predicted attitude, which is the rotation
// vector for small angles.
class RailCost {
 public:
  RailCost(const Rail& rail, double rail_m, const Eigen::Matrix3d& reference,
           const Eigen::Matrix3d& planned)
      : frame_(rail.frame),
        scatter_(rail.scatter),
        rail_m_(rail_m),
        reference_(reference),
        planned_(planned) {}

  template <typename T>
  bool operator()(const T* pose, const T* rail, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    using P = RailParameter;
    const RailAxes<T> axes = rail_axes(frame_.axis, rail[P::kHeading], rail[P::kTilt]);
    const Vector off = Eigen::Map<const Vector>(pose + 3) - rail_position(frame_, rail, rail_m_);
    residual[0] = off.dot(axes.direction) / scatter_.along_m;
    residual[1] = off.dot(axes.across) / scatter_.across_m;
    residual[2] = off.dot(axes.up) / scatter_.across_m;
    const Vector expected = rail_rotation(frame_, rail, rail_m_);
    const Eigen::Quaternion<T> turn = reference_.cast<T>() *
                                      quaternion_of(Vector(Eigen::Map<const Vector>(pose))) *
                                      (quaternion_of(expected) * planned_.cast<T>()).conjugate();
    const T sign = turn.w() < T(0) ? T(-1) : T(1);
    Eigen::Map<Vector>(residual + 3) = sign * T(2.0 / scatter_.rotation_rad) * turn.vec();
    return true;
  }

 private:
  // Its automatic derivatives exist at zero.
  template <typename T>
  static Eigen::Quaternion<T> quaternion_of(const Eigen::Matrix<T, 3, 1>& rotation_vector) {
    T wxyz[4];
    ceres::AngleAxisToQuaternion(rotation_vector.data(), wxyz);
    return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
  }

  RailFrame frame_;
  RailScatter scatter_;
  double rail_m_;
  Eigen::Quaterniond reference_, planned_;
};

// A rail's deviation from the plan, and its bow and twist, in standard deviations.
struct RailPriorCost {
  RailParameters sigmas;

  template <typename T>
  bool operator()(const T* rail, T* residual) const {
    for (std::size_t i = 0; i < sigmas.size(); ++i) residual[i] = rail[i] / sigmas[i];
    return true;
  }
};

// Adds the prior of a rail to `problem`, and holds the parameters that its stations do not support.
void add_rail_prior(Rail* rail, ceres::Problem* problem);

}  // namespace raywalk::calibrate
