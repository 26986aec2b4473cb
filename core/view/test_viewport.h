// For tests: the rays of flat pictures, in double, and the pictures of a synthetic room.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <opencv2/core.hpp>

#include "core/view/viewport.h"
#include "tests/synthetic_room/synthetic_room.h"

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

// The picture of a pinhole camera in a room.
inline cv::Mat true_picture(const SyntheticRoomSpec& spec, PlanPoint at, const Viewport& viewport) {
  const Eigen::Vector3d from_m(at.x_m, spec.height_m, at.z_m);
  cv::Mat picture(viewport.height, viewport.width, CV_8UC3);
  for (int u = 0; u < viewport.width; ++u) {
    for (int v = 0; v < viewport.height; ++v) {
      const Eigen::Vector3d rgb = color_at(spec.scene, from_m, ray_of(viewport, u, v));
      picture.at<cv::Vec3b>(v, u) = {cv::saturate_cast<uchar>(rgb.z()),
                                     cv::saturate_cast<uchar>(rgb.y()),
                                     cv::saturate_cast<uchar>(rgb.x())};
    }
  }
  return picture;
}

}  // namespace raywalk
