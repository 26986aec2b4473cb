// Fisheye lenses, and cameras of two fisheye lenses back to back.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/geometry/sphere.h"

namespace raywalk {

// The radial model of Kannala and Brandt (2006, "A generic camera model and calibration method for
// conventional, wide-angle, and fish-eye lenses"), as in OpenCV's fisheye module. A direction at
// the angle t from the lens's axis is imaged at the distance
//   r = focal_px (t + k[0] t^3 + k[1] t^5 + k[2] t^7 + k[3] t^9)
// from the centre; all k = 0 is the equidistant lens. Lens frame: x right, y up, z along the axis.
struct FisheyeLens {
  PixelPosition centre{};  // of the image circle, in pixels of the frame
  double focal_px = 100.0;
  std::array<double, 4> k{0.0, 0.0, 0.0, 0.0};
  double largest_angle_rad = radians_from_degrees(95.0);  // from the axis; half the field of view
};

// r / focal_px of the model at the angle t (radians). T is double or an automatic-differentiation
// type such as ceres::Jet.
template <typename T, typename Coefficients>
T fisheye_radius(const Coefficients& k, const T& t) {
  const T square = t * t;
  return t * (1.0 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3]))));
}

// Throws Error unless the lens's radius is finite and increases with the angle throughout the field
// of view; otherwise two directions would map to one pixel.
void require_monotonic_radius(const FisheyeLens& lens);

// The pixel of a direction in the lens's frame; none outside the field of view.
std::optional<PixelPosition> project(const FisheyeLens& lens, const Eigen::Vector3d& direction);

// The unit direction in the lens's frame of `pixel`; none outside the field of view.
std::optional<Eigen::Vector3d> unproject(const FisheyeLens& lens, PixelPosition pixel);

// Two image circles, in one frame or in one image each. The camera's frame has the axes of the
// front lens. Its origin is the viewpoint of the stitched panoramas, best placed half way between
// the lenses.
struct DualFisheyeLayout {
  FisheyeLens front{};
  FisheyeLens back{};
  Attitude back_attitude{kPi, 0.0, 0.0};      // of the back lens in the camera's frame
  Eigen::Vector3d front_position_m{0, 0, 0};  // of the lenses in the camera's frame
  Eigen::Vector3d back_position_m{0, 0, 0};
};

// Two equidistant lenses of 190 degrees side by side, front on the left, that fill a frame of
// width = 2 * height as closely as a margin of one hundredth allows.
DualFisheyeLayout simple_dual_fisheye(PanoramaSize frame);

}  // namespace raywalk
