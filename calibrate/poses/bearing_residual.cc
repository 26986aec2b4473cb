#include "calibrate/poses/bearing_residual.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include <cmath>

namespace raywalk::calibrate {
namespace {

class BearingResidual {
 public:
  BearingResidual(const PointObservation& observation, const Eigen::Matrix3d& reference)
      : camera_from_world_(reference.transpose()), centre_m_(observation.centre_m) {
    across_.row(0) = observation.bearing.unitOrthogonal();
    across_.row(1) = observation.bearing.cross(across_.row(0).transpose());
    across_ *= kResidualPx_per_rad;
  }

  template <typename T>
  bool operator()(const T* pose, const T* point, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector> position(pose + 3);
    const Vector seen = camera_from_world_.cast<T>() * (Eigen::Map<const Vector>(point) - position);
    // camera_from_world = exp(w)^T reference^T, and exp(w)^T = exp(-w).
    const Vector back(-pose[0], -pose[1], -pose[2]);
    Vector turned;
    ceres::AngleAxisRotatePoint(back.data(), seen.data(), turned.data());
    turned -= centre_m_.cast<T>();
    Eigen::Map<Eigen::Matrix<T, 2, 1>> out(residual);
    out = across_.cast<T>() * turned / turned.norm();
    return true;
  }

 private:
  Eigen::Matrix3d camera_from_world_;
  Eigen::Vector3d centre_m_;
  Eigen::Matrix<double, 2, 3> across_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> bearing_cost(const PointObservation& observation,
                                                  const Eigen::Matrix3d& reference) {
  using Cost = ceres::AutoDiffCostFunction<BearingResidual, 2, 6, 3>;
  return std::make_unique<Cost>(
      std::make_unique<BearingResidual>(observation, reference).release());
}

double bearing_error_px(const PointObservation& observation,
                        const Eigen::Matrix3d& world_from_camera, const Eigen::Vector3d& position_m,
                        const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d seen =
      world_from_camera.transpose() * (point_m - position_m) - observation.centre_m;
  return kResidualPx_per_rad *
         std::atan2(seen.cross(observation.bearing).norm(), seen.dot(observation.bearing));
}

}  // namespace raywalk::calibrate
