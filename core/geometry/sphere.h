// Directions on the sphere, panorama pixels, and rotations between camera and world.
//
// World frame: metres, x right, y up, z forward; the plan is x-z. The frame is left-handed.
// theta is longitude (0 looks to +z, grows towards +x), phi is latitude (grows upwards).
// A panorama is equirectangular with width = 2 * height; pixel (u, v), counted from 0 at the top
// left, has its centre at theta = (u + 0.5) / W * 2 pi - pi, phi = pi / 2 - (v + 0.5) / H * pi.
#pragma once

#include <Eigen/Core>

namespace raywalk {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kHalfPi = 0.5 * kPi;
inline constexpr double kTwoPi = 2.0 * kPi;

constexpr double degrees_from_radians(double rad) { return rad * (180.0 / kPi); }
constexpr double radians_from_degrees(double deg) { return deg * (kPi / 180.0); }

// A position in the plan, metres in the world frame.
struct PlanPoint {
  double x_m = 0.0;
  double z_m = 0.0;
};

// A direction; theta in [-pi, pi), phi in [-pi/2, pi/2].
struct SphereAngles {
  double theta_rad = 0.0;
  double phi_rad = 0.0;
};

// Panorama size in pixels.
struct PanoramaSize {
  int width = 0;
  int height = 0;
  friend bool operator==(const PanoramaSize&, const PanoramaSize&) = default;
};

// A continuous pixel position; (0, 0) is the centre of the top left pixel.
struct PixelPosition {
  double u = 0.0;
  double v = 0.0;
};

// Attitude of a frame, as in poses.csv: R_world_from_camera = Ry(yaw) Rx(pitch) Rz(roll). yaw turns
// the panorama's centre towards +x, pitch raises it, roll turns the camera clockwise about its
// viewing direction.
struct Attitude {
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
};

// Wraps an angle to [-pi, pi).
double wrap_angle(double angle_rad);

// Unit vector (cos phi sin theta, sin phi, cos phi cos theta).
Eigen::Vector3d direction_from_angles(SphereAngles angles);

// Inverse of direction_from_angles for any nonzero vector, of any length. theta is 0 at the poles.
SphereAngles angles_from_direction(const Eigen::Vector3d& direction);

SphereAngles angles_from_pixel(PixelPosition pixel, PanoramaSize size);
PixelPosition pixel_from_angles(SphereAngles angles, PanoramaSize size);

// The rotation matrix of an attitude; it maps camera-frame directions to world-frame directions.
Eigen::Matrix3d world_from_camera(Attitude attitude);

// The attitude of a rotation matrix: yaw and roll in [-pi, pi], pitch in [-pi/2, pi/2]. At pitch =
// +-pi/2 only a combination of yaw and roll is determined; roll is 0 there.
Attitude attitude_from_world_from_camera(const Eigen::Matrix3d& rotation);

}  // namespace raywalk
