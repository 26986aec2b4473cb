#include "simulator/room/pixel_rays.h"

#include <cmath>

namespace raywalk::capture {

PanoramaRays::PanoramaRays(PanoramaSize size) : size_(size) {
  for (int part = 0; part < size.width * kPixelParts; ++part) {
    const double theta = angles_from_pixel({position_of_part(part), 0.0}, size).theta_rad;
    theta_.push_back({std::sin(theta), std::cos(theta)});
  }
  for (int part = 0; part < size.height * kPixelParts; ++part) {
    const double phi = angles_from_pixel({0.0, position_of_part(part)}, size).phi_rad;
    phi_.push_back({std::sin(phi), std::cos(phi)});
  }
}

std::optional<CameraRay> PanoramaRays::at_part(int part_u, int part_v) const {
  const SineCosine& theta = theta_[static_cast<std::size_t>(part_u)];
  const SineCosine& phi = phi_[static_cast<std::size_t>(part_v)];
  return CameraRay{{0, 0, 0}, {phi.cosine * theta.sine, phi.sine, phi.cosine * theta.cosine}};
}

}  // namespace raywalk::capture
