// For tests: the rays of flat pictures, in double.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "core/view/viewport.h"

namespace raywalk {

// A viewport, angles in degrees.
inline Viewport looking(double yaw, double pitch, double roll, double fov, int width, int height) {
  return {.attitude = {radians_from_degrees(yaw), radians_from_degrees(pitch),
                       radians_from_degrees(roll)},
          .fov_x_rad = radians_from_degrees(fov),
          .width = width,
          .height = height};
}

// The unit direction in the world of a pixel of a pinhole camera.
inline Eigen::Vector3d ray_of(const Viewport& viewport, int column, int row) {
  const double focal_px = 0.5 * viewport.width / std::tan(0.5 * viewport.fov_x_rad);
  const Eigen::Vector3d ray((column + 0.5 - 0.5 * viewport.width) / focal_px,
                            -(row + 0.5 - 0.5 * viewport.height) / focal_px, 1.0);
  return (world_from_camera(viewport.attitude) * ray).normalized();
}

}  // namespace raywalk
