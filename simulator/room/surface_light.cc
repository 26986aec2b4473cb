#include "simulator/room/surface_light.h"

#include <algorithm>
#include <cmath>

namespace raywalk::capture {

Color seen_albedo(const Facet& facet, const Surface& surface, const Ray& ray, double distance,
                  double across) {
  constexpr double kLeastCosine = 0.04;  // bounds the footprint of a grazing ray
  const double facing = facet.normal.dot(ray.direction);
  const Eigen::Vector3d point = ray.origin + distance * ray.direction;
  const Eigen::Vector3d on_texture = point - facet.texture.origin;
  const Eigen::Vector2f at(static_cast<float>(on_texture.dot(facet.texture.s_axis)),
                           static_cast<float>(on_texture.dot(facet.texture.t_axis)));
  // A pixel is `across` wide, and that divided by the cosine along the surface. The footprint is
  // the geometric mean, the side of a square of the same area.
  const double footprint = across / std::sqrt(std::max(std::abs(facing), kLeastCosine));
  return albedo_at(surface, at, static_cast<float>(footprint));
}

}  // namespace raywalk::capture
