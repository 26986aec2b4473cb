// Fisheye lenses, and cameras of two that look away from each other.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/geometry/sphere.h"

namespace raywalk {

// The radial model of Kannala and Brandt (2006, "A generic camera model and calibration method for
// conventional, wide-angle, and fish-eye lenses"), as OpenCV's fisheye module has it. A direction
// at the angle t from the lens's axis is imaged at the distance
//   r = focal_px (t + k[0] t^3 + k[1] t^5 + k[2] t^7 + k[3] t^9)
// from the centre; all k = 0 is the equidistant lens. Lens frame: x right, y up, z along the axis.
struct FisheyeLens {
  PixelPosition centre{};  // of the image circle, in pixels of the frame
  double focal_px = 100.0;
  std::array<double, 4> k{0.0, 0.0, 0.0, 0.0};
  double largest_angle_rad = radians_from_degrees(95.0);  // from the axis; half the field of view
};

// r / focal_px of the model at the angle t, in whatever type of number the caller counts with: a
// double, or one that carries derivatives along.
template <typename T, typename Coefficients>
T fisheye_radius(const Coefficients& k, const T& t) {
  const T square = t * t;
  return t * (1.0 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3]))));
}

// Throws Error where the lens's radius does not grow with the angle all over its field of view, or
// is not a number there: it would image two directions at one place.
void require_growing_radius(const FisheyeLens& lens);

// Where the lens images a direction of its own frame; none beyond its field of view.
std::optional<PixelPosition> project(const FisheyeLens& lens, const Eigen::Vector3d& direction);

// The unit direction in the lens's frame that is imaged at `pixel`; none beyond the field of view.
std::optional<Eigen::Vector3d> unproject(const FisheyeLens& lens, PixelPosition pixel);

// Two image circles, in one frame or each in a picture of its own. The camera's frame has the axes
// of the front lens; its origin, which is where panoramas stitched of the two are said to be taken
// from, is best put half way between the lenses.
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
