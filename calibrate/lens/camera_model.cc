#include "calibrate/lens/camera_model.h"

namespace raywalk::calibrate {
namespace {

LensParameters parameters_of(const FisheyeLens& lens) {
  return {lens.centre.u, lens.centre.v, lens.focal_px, lens.k[0], lens.k[1], lens.k[2], lens.k[3]};
}

FisheyeLens lens_of(const LensParameters& parameters, const FisheyeLens& start) {
  FisheyeLens lens = start;
  lens.centre = {parameters[0], parameters[1]};
  lens.focal_px = parameters[2];
  lens.k = {parameters[3], parameters[4], parameters[5], parameters[6]};
  return lens;
}

}  // namespace

CameraFrame camera_frame_of(const DualFisheyeLayout& start) {
  return {world_from_camera(start.back_attitude).transpose(),
          0.5 * (start.front_position_m + start.back_position_m)};
}

CameraParameters parameters_of(const DualFisheyeLayout& start) {
  const Eigen::Vector3d baseline_m = start.back_position_m - start.front_position_m;
  return {parameters_of(start.front),
          parameters_of(start.back),
          {0.0, 0.0, 0.0, baseline_m.x(), baseline_m.y(), baseline_m.z()}};
}

DualFisheyeLayout layout_of(const CameraParameters& parameters, const DualFisheyeLayout& start) {
  const CameraFrame frame = camera_frame_of(start);
  DualFisheyeLayout layout = start;
  layout.front = lens_of(parameters.front, start.front);
  layout.back = lens_of(parameters.back, start.back);
  const PoseParameters& pose = parameters.back_pose;
  Eigen::Matrix3d turn;
  ceres::AngleAxisToRotationMatrix(pose.data(), turn.data());
  layout.back_attitude =
      attitude_from_world_from_camera((turn * frame.back_from_camera).transpose());
  const Eigen::Vector3d baseline_m(pose[3], pose[4], pose[5]);
  layout.front_position_m = frame.middle_m - 0.5 * baseline_m;
  layout.back_position_m = frame.middle_m + 0.5 * baseline_m;
  return layout;
}

// Typical deviations from a maker's figures are at most a tenth of the radius in the centre, a
// fifth in the focal length, and a third of the radius at the rim in each term of the polynomial.
LensPrior::LensPrior(const FisheyeLens& start) : start_(parameters_of(start)) {
  const double rim = fisheye_radius(start.k, start.largest_angle_rad);
  sigma_[0] = sigma_[1] = 0.1 * rim * start.focal_px;
  sigma_[2] = 0.2 * start.focal_px;
  double power = start.largest_angle_rad;
  for (std::size_t i = 3; i < kLensParameters; ++i) {
    power *= start.largest_angle_rad * start.largest_angle_rad;
    sigma_[i] = rim / (3.0 * power);
  }
}

}  // namespace raywalk::calibrate
