// Camera model of a 360-degree camera with two fisheye lenses, for the renderer.
#pragma once

#include <optional>

#include "core/geometry/fisheye_lens.h"
#include "simulator/room/pixel_rays.h"

namespace raywalk::capture {

// Whether a pixel of a dual-fisheye frame belongs to the front lens, that is, is nearer to its
// centre.
bool belongs_to_front(const DualFisheyeLayout& layout, PixelPosition pixel);

// The rays of a dual-fisheye frame.
class DualFisheyeRays final : public PixelRays {
 public:
  // Throws Error unless the image radius of each lens is finite and increases with the angle over
  // its field of view.
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
