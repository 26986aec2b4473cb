// A 360-degree camera of two fisheye lenses that look away from each other.
#pragma once

#include <array>
#include <optional>

#include "capture/simulated/virtual_room/pixel_rays.h"

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

// Where the lens images a direction of its own frame; none beyond its field of view.
std::optional<PixelPosition> project(const FisheyeLens& lens, const Eigen::Vector3d& direction);

// The unit direction in the lens's frame that is imaged at `pixel`; none beyond the field of view.
std::optional<Eigen::Vector3d> unproject(const FisheyeLens& lens, PixelPosition pixel);

// Two image circles in one frame. The camera's frame is that of the front lens.
struct DualFisheyeLayout {
  FisheyeLens front{};
  FisheyeLens back{};
  Attitude back_attitude{kPi, 0.0, 0.0};     // of the back lens in the camera's frame
  Eigen::Vector3d back_position_m{0, 0, 0};  // of the back lens in the camera's frame
};

// Two equidistant lenses of 190 degrees side by side, front on the left, that fill a frame of
// width = 2 * height as closely as a margin of one hundredth allows.
DualFisheyeLayout simple_dual_fisheye(PanoramaSize frame);

// The rays of a dual-fisheye frame. A pixel belongs to the lens whose centre is nearer.
class DualFisheyeRays final : public PixelRays {
 public:
  // Throws Error where a lens's radius does not grow with the angle all over its field of view, or
  // is not a number there.
  DualFisheyeRays(const DualFisheyeLayout& layout, PanoramaSize frame);

  int width() const override { return frame_.width; }
  int height() const override { return frame_.height; }
  double pixel_rad() const override { return 1.0 / layout_.front.focal_px; }
  std::optional<CameraRay> at_part(int part_u, int part_v) const override;

 private:
  DualFisheyeLayout layout_;
  PanoramaSize frame_;
  Eigen::Matrix3d front_from_back_;
};

}  // namespace raywalk
