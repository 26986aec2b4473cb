#include "simulator/room/eye_rays.h"

#include "core/geometry/eye_circle.h"

namespace raywalk::capture {

EyeRays::EyeRays(PanoramaSize size, double eye_radius_m) : panorama_(size) {
  const EyeCircle eye{{0, 0, 0}, eye_radius_m};
  for (int part = 0; part < size.width * kPixelParts; ++part) {
    origins_m_.push_back(
        eye.position_m(angles_from_pixel({position_of_part(part), 0.0}, size).theta_rad));
  }
}

std::optional<CameraRay> EyeRays::at_part(int part_u, int part_v) const {
  std::optional<CameraRay> ray = panorama_.at_part(part_u, part_v);
  ray->origin_m = origins_m_[static_cast<std::size_t>(part_u)];
  return ray;
}

}  // namespace raywalk::capture
