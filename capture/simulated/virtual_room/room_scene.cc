#include "capture/simulated/virtual_room/room_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/simulated/virtual_room/picture_patterns.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

constexpr double kOffMirror = 1e-4;  // offset of a reflected ray's origin, room units
constexpr float kMirrorReflectance = 0.92F;
constexpr double kLeastCosine = 0.04;  // bounds the footprint of a grazing ray

}  // namespace

RoomScene::RoomScene(const RoomPlan& plan, const ContentSettings& contents)
    : room_(furnish(plan, contents)),
      scene_(room_.facets.facets),
      light_map_(room_.facets, scene_, room_.lights) {}

const Surface& RoomScene::surface_of(const Hit& hit) const {
  return room_.facets.surfaces[static_cast<std::size_t>(facet(hit.facet).surface)];
}

void RoomScene::look(std::span<const Ray> rays, double pixel_rad, std::span<Color> lights) const {
  // Reused across millions of calls.
  thread_local std::vector<Hit> hits;
  hits.resize(rays.size());
  scene_.intersect(rays, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) lights[i] = light_of(rays[i], hits[i], pixel_rad);
}

void RoomScene::measure(std::span<const Ray> rays, std::span<double> distances) const {
  thread_local std::vector<Hit> hits;
  hits.resize(rays.size());
  scene_.intersect(rays, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool far = hits[i].facet < 0 || surface_of(hits[i]).pattern == Pattern::kSky;
    distances[i] = far ? std::numeric_limits<double>::infinity() : hits[i].distance;
  }
}

Color RoomScene::light_of(const Ray& ray, const Hit& hit, double pixel_rad) const {
  if (hit.facet >= 0 && surface_of(hit).pattern == Pattern::kMirror) {
    return reflection(ray, hit, pixel_rad);
  }
  return diffuse_light(ray, hit, 0.0, pixel_rad);
}

// Reflects d into d - 2 (d . n) n. There is a single flat mirror, so one reflection suffices.
Color RoomScene::reflection(const Ray& ray, const Hit& hit, double pixel_rad) const {
  const Vector3d& normal = facet(hit.facet).normal;
  Ray reflected;
  reflected.direction = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
  reflected.origin = ray.origin + hit.distance * ray.direction + kOffMirror * normal;
  const Hit seen = scene_.intersect(reflected);
  return kMirrorReflectance * diffuse_light(reflected, seen, hit.distance, pixel_rad);
}

Color RoomScene::diffuse_light(const Ray& ray, const Hit& hit, double travelled,
                               double pixel_rad) const {
  if (hit.facet < 0 || surface_of(hit).pattern == Pattern::kSky) {
    return sky_light(ray.direction, static_cast<float>(pixel_rad), room_.lights.sky_seed);
  }
  const Facet& seen = facet(hit.facet);
  const Surface& surface = surface_of(hit);
  const double facing = seen.normal.dot(ray.direction);
  const Vector3d point = ray.origin + hit.distance * ray.direction;
  const Vector3d on_texture = point - seen.texture.origin;
  const Eigen::Vector2f at(static_cast<float>(on_texture.dot(seen.texture.s_axis)),
                           static_cast<float>(on_texture.dot(seen.texture.t_axis)));
  // A pixel covers distance x angle across the ray, and that divided by the cosine along the
  // surface. The footprint is the geometric mean, the side of a square of the same area.
  const double footprint =
      (travelled + hit.distance) * pixel_rad / std::sqrt(std::max(std::abs(facing), kLeastCosine));
  Color albedo = albedo_at(surface, at, static_cast<float>(footprint));
  if (surface.pattern == Pattern::kShade) return albedo;
  const Vector3d normal = seen.two_sided && facing > 0.0 ? Vector3d(-seen.normal) : seen.normal;
  return albedo.cwiseProduct(light_map_.at(hit, point, normal));
}

}  // namespace raywalk::capture
