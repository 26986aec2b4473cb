#include "core/geometry/sphere.h"

#include <cmath>

namespace raywalk {

double wrap_angle(double angle_rad) {
  // std::remainder is exact and in [-pi, pi]; the upper end is mapped to the lower one.
  const double wrapped = std::remainder(angle_rad, kTwoPi);
  return wrapped >= kPi ? wrapped - kTwoPi : wrapped;
}

Eigen::Vector3d direction_from_angles(SphereAngles angles) {
  const double in_plan = std::cos(angles.phi_rad);
  return {in_plan * std::sin(angles.theta_rad), std::sin(angles.phi_rad),
          in_plan * std::cos(angles.theta_rad)};
}

SphereAngles angles_from_direction(const Eigen::Vector3d& direction) {
  const double x = direction.x();
  const double y = direction.y();
  const double z = direction.z();
  // atan2 of the plan length keeps full precision at the poles, where asin(y) loses half the
  // digits.
  const double phi_rad = std::atan2(y, std::hypot(x, z));
  // atan2 of two zeros depends on their signs; a pole has no longitude.
  if (x == 0.0 && z == 0.0) return {0.0, phi_rad};
  return {wrap_angle(std::atan2(x, z)), phi_rad};
}

SphereAngles angles_from_pixel(PixelPosition pixel, PanoramaSize size) {
  // Relative to the panorama's centre, so that mirrored pixels get exactly mirrored angles.
  const double right = (pixel.u + 0.5) - 0.5 * size.width;
  const double up = 0.5 * size.height - (pixel.v + 0.5);
  return {wrap_angle(right / size.width * kTwoPi), up / size.height * kPi};
}

PixelPosition pixel_from_angles(SphereAngles angles, PanoramaSize size) {
  const double right = angles.theta_rad / kTwoPi * size.width;
  const double up = angles.phi_rad / kPi * size.height;
  return {right + 0.5 * size.width - 0.5, 0.5 * size.height - up - 0.5};
}

Eigen::Matrix3d world_from_camera(Attitude attitude) {
  // The columns of each factor are the images of the x, y and z axes. The frame is left-handed, and
  // so are positive rotations: yaw turns z towards x, pitch z towards y, roll y towards x
  // (clockwise when looking along +z with x to the right).
  const double cy = std::cos(attitude.yaw_rad);
  const double sy = std::sin(attitude.yaw_rad);
  const double cp = std::cos(attitude.pitch_rad);
  const double sp = std::sin(attitude.pitch_rad);
  const double cr = std::cos(attitude.roll_rad);
  const double sr = std::sin(attitude.roll_rad);
  Eigen::Matrix3d yaw;
  yaw << cy, 0, sy,  //
      0, 1, 0,       //
      -sy, 0, cy;
  Eigen::Matrix3d pitch;
  pitch << 1, 0, 0,  //
      0, cp, sp,     //
      0, -sp, cp;
  Eigen::Matrix3d roll;
  roll << cr, sr, 0,  //
      -sr, cr, 0,     //
      0, 0, 1;
  return yaw * pitch * roll;
}

// R = Ry Rx Rz multiplied out: its third column is (sin yaw cos pitch, sin pitch, cos yaw cos
// pitch), its second row (-cos pitch sin roll, cos pitch cos roll, sin pitch).
Attitude attitude_from_world_from_camera(const Eigen::Matrix3d& rotation) {
  const double in_plan = std::hypot(rotation(0, 2), rotation(2, 2));
  const double pitch = std::atan2(rotation(1, 2), in_plan);
  // Below this the plan direction is rounding error; with roll = 0 the first column is (cos yaw, 0,
  // -sin yaw).
  constexpr double kStraightUp = 1e-12;
  if (in_plan < kStraightUp) return {std::atan2(-rotation(2, 0), rotation(0, 0)), pitch, 0.0};
  return {std::atan2(rotation(0, 2), rotation(2, 2)), pitch,
          std::atan2(-rotation(1, 0), rotation(1, 1))};
}

}  // namespace raywalk
