#include "simulator/room/room_scene.h"

#include <cmath>
#include <limits>

#include "simulator/room/hall.h"
#include "simulator/room/picture_patterns.h"
#include "simulator/room/street_canyon.h"
#include "simulator/room/surface_light.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

constexpr double kOffMirror = 1e-4;  // offset of a reflected ray's origin, room units
constexpr float kMirrorReflectance = 0.92F;

FurnishedRoom furnished(const RoomPlan& plan, const VirtualRoomSettings& settings) {
  if (settings.place == "canyon") return build_canyon(plan, settings);
  if (settings.place == "hall") return build_hall(plan, settings);
  return furnish(plan, settings.contents);
}

// Whether a hit hides another along the same ray.
bool is_before(const Hit& hit, const Hit& other) {
  return hit.facet >= 0 && (other.facet < 0 || hit.distance < other.distance);
}

double distance_of(const Hit& hit) {
  return hit.facet >= 0 ? hit.distance : std::numeric_limits<double>::infinity();
}

// Reflects d into d - 2 (d . n) n; `normal` is on the side that the ray comes from.
Ray reflected_ray(const Ray& ray, double distance, const Vector3d& normal) {
  Ray reflected;
  reflected.direction = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
  reflected.origin = ray.origin + distance * ray.direction + kOffMirror * normal;
  return reflected;
}

// The share of light that a pane of refractive index 1.5 reflects at the cosine of incidence:
// Schlick's approximation (1994, "An inexpensive BRDF model for physically-based rendering") for
// each of its two surfaces, between which light goes to and fro.
float pane_reflectance(double cosine) {
  constexpr double kStraight = 0.04;  // ((1.5 - 1) / (1.5 + 1))^2
  const double surface = kStraight + (1.0 - kStraight) * std::pow(1.0 - cosine, 5);
  return static_cast<float>(2.0 * surface / (1.0 + surface));
}

}  // namespace

RoomScene::RoomScene(const RoomPlan& plan, const VirtualRoomSettings& settings)
    : room_(furnished(plan, settings)),
      scene_(room_.facets.facets),
      source_gain_(static_cast<float>(settings.light.source_gain)),
      light_map_(room_.facets, scene_, room_.lights) {
  if (!room_.glass.facets.empty()) glass_.emplace(room_.glass.facets);
}

const Surface& RoomScene::surface_of(const Hit& hit) const {
  return room_.facets.surfaces[static_cast<std::size_t>(facet(hit.facet).surface)];
}

void RoomScene::look(std::span<const Ray> rays, double pixel_rad, std::span<Color> lights,
                     const PeopleScene* people) const {
  // Reused across millions of calls.
  thread_local std::vector<Hit> hits;
  hits.resize(rays.size());
  scene_.intersect(rays, hits);
  thread_local std::vector<Hit> persons;
  if (people != nullptr) {
    persons.resize(rays.size());
    people->intersect(rays, persons);
  }
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool person = people != nullptr && is_before(persons[i], hits[i]);
    lights[i] = person ? people->light_of(rays[i], persons[i], pixel_rad)
                       : light_of(rays[i], hits[i], 0.0, pixel_rad);
    if (!glass_) continue;
    const Hit& first = person ? persons[i] : hits[i];
    lights[i] = through_glass(rays[i], distance_of(first), lights[i], pixel_rad);
  }
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

Color RoomScene::light_of(const Ray& ray, const Hit& hit, double travelled,
                          double pixel_rad) const {
  if (hit.facet >= 0 && surface_of(hit).pattern == Pattern::kMirror) {
    return reflection(ray, hit, travelled, pixel_rad);
  }
  return diffuse_light(ray, hit, travelled, pixel_rad);
}

// There is a single flat mirror, so one reflection suffices. It shows neither panes nor people.
Color RoomScene::reflection(const Ray& ray, const Hit& hit, double travelled,
                            double pixel_rad) const {
  const Ray reflected = reflected_ray(ray, hit.distance, facet(hit.facet).normal);
  const Hit seen = scene_.intersect(reflected);
  return kMirrorReflectance * diffuse_light(reflected, seen, travelled + hit.distance, pixel_rad);
}

// Each pane mixes what it reflects with what is behind it.
Color RoomScene::through_glass(const Ray& ray, double distance, const Color& seen,
                               double pixel_rad) const {
  Color sum = Color::Zero();
  float passed = 1.0F;
  double travelled = 0.0;
  Ray rest = ray;
  for (Hit pane = glass_->intersect(rest); pane.facet >= 0 && travelled + pane.distance < distance;
       pane = glass_->intersect(rest)) {
    const Vector3d& normal = room_.glass.facets[static_cast<std::size_t>(pane.facet)].normal;
    const float share = pane_reflectance(std::abs(normal.dot(ray.direction)));
    const Ray reflected = reflected_ray(
        rest, pane.distance, normal.dot(ray.direction) < 0.0 ? normal : Vector3d(-normal));
    travelled += pane.distance + kOffMirror;
    sum += passed * share * light_of(reflected, scene_.intersect(reflected), travelled, pixel_rad);
    passed *= 1.0F - share;
    rest.origin = ray.origin + travelled * ray.direction;
  }
  return sum + passed * seen;
}

Color RoomScene::diffuse_light(const Ray& ray, const Hit& hit, double travelled,
                               double pixel_rad) const {
  if (hit.facet < 0 || surface_of(hit).pattern == Pattern::kSky) {
    return source_gain_ *
           sky_light(ray.direction, static_cast<float>(pixel_rad), room_.lights.sky_seed);
  }
  const Facet& seen = facet(hit.facet);
  const Surface& surface = surface_of(hit);
  const double facing = seen.normal.dot(ray.direction);
  const Vector3d point = ray.origin + hit.distance * ray.direction;
  const Color albedo =
      seen_albedo(seen, surface, ray, hit.distance, (travelled + hit.distance) * pixel_rad);
  if (surface.pattern == Pattern::kShade) return source_gain_ * albedo;
  const Vector3d normal = seen.two_sided && facing > 0.0 ? Vector3d(-seen.normal) : seen.normal;
  return albedo.cwiseProduct(light_map_.at(hit, point, normal));
}

}  // namespace raywalk::capture
