#include "calibrate/lens/camera_model.h"

#include <algorithm>
#include <cmath>

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

using LensCovariance = Eigen::Matrix<double, kLensParameters, kLensParameters>;

// Root mean square over the azimuths of the standard deviation of the image position at the angle
// t. With c, s the cosine and sine of the azimuth the position is (u + f m(t) c, v - f m(t) s),
// where m(t) is fisheye_radius; the derivatives are below.
double imaging_sigma_px(const LensParameters& lens, const LensCovariance& covariance, double t) {
  constexpr int kAzimuths = 16;
  double variance = 0.0;
  for (int i = 0; i < kAzimuths; ++i) {
    const double azimuth = kTwoPi * i / kAzimuths;
    Eigen::Matrix<double, 1, kLensParameters> along;  // of the radius, without the centre
    along.setZero();
    along[2] = fisheye_radius(lens.data() + 3, t);
    double power = lens[2] * t;
    for (int k = 3; k < kLensParameters; ++k) along[k] = power *= t * t;
    Eigen::Matrix<double, 2, kLensParameters> slope;
    slope.row(0) = std::cos(azimuth) * along;
    slope.row(1) = -std::sin(azimuth) * along;
    slope(0, 0) = slope(1, 1) = 1.0;
    variance += (slope * covariance * slope.transpose()).trace() / kAzimuths;
  }
  return std::sqrt(variance);
}

LensUncertainty uncertainty_of_lens(const LensParameters& lens, const LensCovariance& covariance,
                                    double largest_angle_rad) {
  const auto sigma = [&](int i) { return std::sqrt(covariance(i, i)); };
  LensUncertainty result;
  result.centre_u_px = sigma(0);
  result.centre_v_px = sigma(1);
  result.focal_px = sigma(2);
  result.k = {sigma(3), sigma(4), sigma(5), sigma(6)};
  result.middle_px = imaging_sigma_px(lens, covariance, 0.5 * largest_angle_rad);
  result.rim_px = imaging_sigma_px(lens, covariance, largest_angle_rad);
  return result;
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

CameraUncertainty uncertainty_of(const CameraParameters& parameters,
                                 const CameraCovariance& covariance,
                                 const DualFisheyeLayout& layout) {
  CameraUncertainty result;
  result.front = uncertainty_of_lens(parameters.front,
                                     covariance.block<kLensParameters, kLensParameters>(0, 0),
                                     layout.front.largest_angle_rad);
  result.back = uncertainty_of_lens(
      parameters.back,
      covariance.block<kLensParameters, kLensParameters>(kLensParameters, kLensParameters),
      layout.back.largest_angle_rad);
  for (int i = 0; i < 3; ++i) {
    const int rotation = 2 * kLensParameters + i;
    const int position = rotation + 3;
    result.back_rotation_deg[i] = degrees_from_radians(std::sqrt(covariance(rotation, rotation)));
    result.baseline_mm[i] = 1000.0 * std::sqrt(covariance(position, position));
  }
  return result;
}

double CameraUncertainty::worst_px() const {
  return std::max({front.middle_px, front.rim_px, back.middle_px, back.rim_px});
}

}  // namespace raywalk::calibrate
