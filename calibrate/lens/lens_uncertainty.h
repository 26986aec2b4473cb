// The uncertainty of a fitted camera, from the covariance of its parameters.
#pragma once

#include <Eigen/Core>
#include <array>

#include "calibrate/lens/camera_model.h"

namespace raywalk::calibrate {

// Standard deviations.
struct LensUncertainty {
  double centre_u_px = 0.0;
  double centre_v_px = 0.0;
  double focal_px = 0.0;
  std::array<double, 4> k{};
  // Of the image position of a direction, root mean square over the directions around the axis. The
  // coefficients are strongly correlated, so only this measures the quality of the lens model.
  double middle_px = 0.0;  // half way to the rim, in angle
  double rim_px = 0.0;     // at the largest angle
};

struct CameraUncertainty {
  LensUncertainty front{};
  LensUncertainty back{};
  Eigen::Vector3d back_rotation_deg{0, 0, 0};  // about the back lens's x, y and z
  Eigen::Vector3d baseline_mm{0, 0, 0};        // from the front lens to the back lens

  double worst_px() const;  // the largest of the four imaging errors
};

// Covariance of front, back and back_pose of CameraParameters, in this order.
inline constexpr int kCameraParameters = 2 * kLensParameters + kPoseParameters;
using CameraCovariance = Eigen::Matrix<double, kCameraParameters, kCameraParameters>;

CameraUncertainty uncertainty_of(const CameraParameters& parameters,
                                 const CameraCovariance& covariance,
                                 const DualFisheyeLayout& layout);

}  // namespace raywalk::calibrate
