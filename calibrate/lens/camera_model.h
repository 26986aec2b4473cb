// The dual-fisheye camera as a function of the parameters of a least-squares problem.
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "calibrate/lens/calibrate_lens.h"
#include "core/geometry/fisheye_lens.h"

namespace raywalk::calibrate {

// u and v of the centre and the focal length, in pixels, then the four coefficients.
inline constexpr int kLensParameters = 7;
using LensParameters = std::array<double, kLensParameters>;

// A rotation vector (axis times angle, radians), then a translation in metres.
inline constexpr int kPoseParameters = 6;
using PoseParameters = std::array<double, kPoseParameters>;

// The constants of the camera, from the start.
struct CameraFrame {
  Eigen::Matrix3d back_from_camera = Eigen::Matrix3d::Identity();  // of the start
  Eigen::Vector3d middle_m{0, 0, 0};                               // between the lenses
};

// `back_pose` is the rotation of the back lens relative to the start (in the back lens's own frame)
// and the translation from the front lens to the back lens. Half of the translation lies on either
// side of the middle, so the camera's origin stays that of the start.
struct CameraParameters {
  LensParameters front{};
  LensParameters back{};
  PoseParameters back_pose{};
};

// Covariance of front, back and back_pose of CameraParameters, in this order.
inline constexpr int kCameraParameters = 2 * kLensParameters + kPoseParameters;
using CameraCovariance = Eigen::Matrix<double, kCameraParameters, kCameraParameters>;

// The standard deviations that follow from it.
CameraUncertainty uncertainty_of(const CameraParameters& parameters,
                                 const CameraCovariance& covariance,
                                 const DualFisheyeLayout& layout);

CameraFrame camera_frame_of(const DualFisheyeLayout& start);
CameraParameters parameters_of(const DualFisheyeLayout& start);
// The layout with these parameters; what they do not contain, such as the field of view, is taken
// from `start`.
DualFisheyeLayout layout_of(const CameraParameters& parameters, const DualFisheyeLayout& start);

// The image of a direction in the lens's own frame, as project() in fisheye_lens.h, but also beyond
// the field of view: a solver needs values on both sides of every limit.
template <typename T>
void image_direction(const T* lens, const T* direction, T* pixel) {
  using std::atan2;
  using std::sqrt;
  const T square = direction[0] * direction[0] + direction[1] * direction[1];
  // On the axis the angle over the distance from the axis tends to 1 / z, while the derivative of
  // the square root does not exist.
  constexpr double kOnAxis = 1e-24;
  T scale = lens[2] / direction[2];
  if (square > kOnAxis * direction[2] * direction[2]) {
    const T off_axis = sqrt(square);
    scale = lens[2] * fisheye_radius(lens + 3, T(atan2(off_axis, direction[2]))) / off_axis;
  }
  pixel[0] = lens[0] + scale * direction[0];
  pixel[1] = lens[1] - scale * direction[1];
}

// The image of the point `at` / `inverse_scale` (camera's frame) in the front or back lens;
// inverse_scale = 0 is a point at infinity in the direction `at`.
template <typename T>
void image_point(const CameraFrame& frame, bool back, const T* lens, const T* back_pose,
                 const T* at, const T& inverse_scale, T* pixel) {
  const double side = back ? 0.5 : -0.5;
  T ray[3];
  for (int i = 0; i < 3; ++i) {
    ray[i] = at[i] - inverse_scale * (frame.middle_m[i] + side * back_pose[3 + i]);
  }
  if (!back) return image_direction(lens, ray, pixel);
  const Eigen::Matrix3d& turn = frame.back_from_camera;
  T turned[3], in_lens[3];
  for (int i = 0; i < 3; ++i) {
    turned[i] = turn(i, 0) * ray[0] + turn(i, 1) * ray[1] + turn(i, 2) * ray[2];
  }
  ceres::AngleAxisRotatePoint(back_pose, turned, in_lens);
  image_direction(lens, in_lens, pixel);
}

}  // namespace raywalk::calibrate
