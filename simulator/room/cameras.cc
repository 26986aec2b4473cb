#include "simulator/room/cameras.h"

#include <cmath>

#include "core/base/error.h"
#include "core/geometry/eye_circle.h"

namespace raywalk::capture {
namespace {

// Continuous pixel coordinate (sphere.h) of a part.
double position_of_part(int part) { return (part + 0.5) / kPixelParts - 0.5; }

double squared_distance(PixelPosition a, PixelPosition b) {
  return (a.u - b.u) * (a.u - b.u) + (a.v - b.v) * (a.v - b.v);
}

}  // namespace

PanoramaRays::PanoramaRays(PanoramaSize size, double eye_radius_m) : size_(size) {
  if (size.height < 1 || size.width != 2 * size.height) {
    throw Error("a panorama of the virtual room must be twice as wide as high");
  }
  const EyeCircle eye{{0, 0, 0}, eye_radius_m};
  for (int part = 0; part < size.width * kPixelParts; ++part) {
    const double theta = angles_from_pixel({position_of_part(part), 0.0}, size).theta_rad;
    theta_.push_back({std::sin(theta), std::cos(theta)});
    origins_m_.push_back(eye.position_m(theta));
  }
  for (int part = 0; part < size.height * kPixelParts; ++part) {
    const double phi = angles_from_pixel({0.0, position_of_part(part)}, size).phi_rad;
    phi_.push_back({std::sin(phi), std::cos(phi)});
  }
}

std::optional<CameraRay> PanoramaRays::at_part(int part_u, int part_v) const {
  const auto column = static_cast<std::size_t>(part_u);
  const SineCosine& theta = theta_[column];
  const SineCosine& phi = phi_[static_cast<std::size_t>(part_v)];
  return CameraRay{origins_m_[column],
                   {phi.cosine * theta.sine, phi.sine, phi.cosine * theta.cosine}};
}

bool belongs_to_front(const DualFisheyeLayout& layout, PixelPosition pixel) {
  return squared_distance(pixel, layout.front.centre) <=
         squared_distance(pixel, layout.back.centre);
}

DualFisheyeRays::DualFisheyeRays(const DualFisheyeLayout& layout, PanoramaSize frame)
    : layout_(layout), frame_(frame), front_from_back_(world_from_camera(layout.back_attitude)) {
  require_monotonic_radius(layout.front);
  require_monotonic_radius(layout.back);
}

std::optional<CameraRay> DualFisheyeRays::at_part(int part_u, int part_v) const {
  const PixelPosition pixel{position_of_part(part_u), position_of_part(part_v)};
  if (belongs_to_front(layout_, pixel)) {
    const auto direction = unproject(layout_.front, pixel);
    return direction ? std::optional(CameraRay{layout_.front_position_m, *direction})
                     : std::nullopt;
  }
  const auto direction = unproject(layout_.back, pixel);
  if (!direction) return std::nullopt;
  return CameraRay{layout_.back_position_m, front_from_back_ * *direction};
}

}  // namespace raywalk::capture
