// For tests: a camera with known lenses, and the error of a fitted one.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/files/lens_file.h"
#include "core/geometry/fisheye_lens.h"

namespace raywalk::calibrate {

// The camera by its maker's figures: two equidistant lenses of 190 degrees.
inline DualFisheyeCamera plain_camera(PanoramaSize picture) {
  return {picture, false, simple_dual_fisheye(picture)};
}

// The true camera: a few per cent off in every parameter, 194 degrees.
inline DualFisheyeCamera true_camera(PanoramaSize picture) {
  DualFisheyeCamera camera = plain_camera(picture);
  const double px = picture.width / 1120.0;
  const auto change = [&](FisheyeLens* lens, double right_px, double down_px, double focal_share,
                          std::array<double, 4> k) {
    lens->centre.u += right_px * px;
    lens->centre.v += down_px * px;
    lens->focal_px *= focal_share;
    lens->k = k;
    lens->largest_angle_rad = radians_from_degrees(97.0);
  };
  change(&camera.layout.front, 3.1, -2.2, 0.985, {0.012, -0.006, 0.0011, -0.0001});
  change(&camera.layout.back, -2.4, 1.7, 0.988, {0.010, -0.005, 0.0013, -0.00014});
  camera.layout.back_attitude = {radians_from_degrees(180.4), radians_from_degrees(-0.3),
                                 radians_from_degrees(0.5)};
  camera.layout.front_position_m = {0.0002, -0.0001, 0.005};
  camera.layout.back_position_m = {-0.0002, 0.0001, -0.005};
  return camera;
}

inline Eigen::Vector3d at_angle(double off_axis_rad, double around_rad) {
  return {std::sin(off_axis_rad) * std::cos(around_rad),
          std::sin(off_axis_rad) * std::sin(around_rad), std::cos(off_axis_rad)};
}

// Root mean square distance of the images of the same direction in two lenses, over directions that
// are uniform over the image circle. `a_from_b` turns the axes of `b` into those of `a`.
inline double imaging_difference_px(const FisheyeLens& a, const FisheyeLens& b,
                                    const Eigen::Matrix3d& a_from_b = Eigen::Matrix3d::Identity()) {
  constexpr int kRings = 40, kAzimuths = 24;
  const double limit = std::min(a.largest_angle_rad, b.largest_angle_rad);
  double sum = 0.0;
  int count = 0;
  for (int ring = 0; ring < kRings; ++ring) {
    for (int i = 0; i < kAzimuths; ++i) {
      const Eigen::Vector3d in_b =
          at_angle(limit * std::sqrt((ring + 0.5) / kRings), kTwoPi * i / kAzimuths);
      const auto at_a = project(a, a_from_b * in_b), at_b = project(b, in_b);
      if (!at_a || !at_b) continue;
      sum += (at_a->u - at_b->u) * (at_a->u - at_b->u) + (at_a->v - at_b->v) * (at_a->v - at_b->v);
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

// The same for a whole camera, for the worse lens: directions are in the camera's frame, so the
// attitude of the back lens counts.
inline double imaging_difference_px(const DualFisheyeLayout& a, const DualFisheyeLayout& b) {
  const Eigen::Matrix3d a_from_b =
      world_from_camera(a.back_attitude).transpose() * world_from_camera(b.back_attitude);
  return std::max(imaging_difference_px(a.front, b.front),
                  imaging_difference_px(a.back, b.back, a_from_b));
}

}  // namespace raywalk::calibrate
