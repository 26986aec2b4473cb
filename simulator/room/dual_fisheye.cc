#include "simulator/room/dual_fisheye.h"

namespace raywalk::capture {
namespace {

double squared_distance(PixelPosition a, PixelPosition b) {
  return (a.u - b.u) * (a.u - b.u) + (a.v - b.v) * (a.v - b.v);
}

}  // namespace

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
