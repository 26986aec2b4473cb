// A 360-degree camera of two fisheye lenses, as the renderer of the virtual room needs it.
#pragma once

#include <optional>

#include "capture/simulated/virtual_room/pixel_rays.h"
#include "core/geometry/fisheye_lens.h"

namespace raywalk::capture {

// A pixel of a dual-fisheye frame belongs to the lens whose centre is nearer.
bool belongs_to_front(const DualFisheyeLayout& layout, PixelPosition pixel);

// The rays of a dual-fisheye frame.
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

}  // namespace raywalk::capture
