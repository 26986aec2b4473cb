// The light along rays through a virtual room.
#include <cmath>
#include <limits>
#include <utility>

#include "core/geometry/sphere.h"
#include "simulator/room/bodies.h"
#include "simulator/room/surface.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector3d;

constexpr double kOffMirror = 1e-4;  // offset of a reflected ray's origin
constexpr float kMirrorReflectance = 0.92F;

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

// The reflectance where the ray meets the facet, `distance` from the ray's origin, filtered for a
// pixel that is `across` wide there, across the ray.
Color seen_albedo(const Facet& facet, const Surface& surface, const Ray& ray, double distance,
                  double across) {
  constexpr double kLeastCosine = 0.04;  // bounds the footprint of a grazing ray
  const TextureFrame& texture = facet.texture;
  const Vector3d from_origin = ray.origin + distance * ray.direction - texture.origin;
  const Eigen::Vector2d at = texture.at_origin + Eigen::Vector2d(from_origin.dot(texture.s_axis),
                                                                 from_origin.dot(texture.t_axis));
  // A pixel is `across` wide, and that divided by the cosine along the surface. The footprint is
  // the geometric mean, the side of a square of the same area.
  const double facing = std::abs(facet.normal.dot(ray.direction));
  const double footprint =
      across / std::sqrt(std::max(facing, kLeastCosine)) * texture.s_axis.norm();
  return albedo_at(surface, at.cast<float>(), static_cast<float>(footprint));
}

// Directions distributed evenly over the sphere (Fibonacci lattice): equal steps in height, golden
// angle in longitude.
Vector3d spread_direction(int index, int count) {
  const double golden_angle = kPi * (3.0 - std::sqrt(5.0));
  const double height = (2.0 * index + 1.0) / count - 1.0;
  return direction_from_angles({wrap_angle(golden_angle * index), std::asin(height)});
}

}  // namespace

Bodies::Bodies(Facets bodies, std::size_t moving)
    : bodies_(std::move(bodies)), moving_(static_cast<int>(moving)), scene_(bodies_.facets) {}

bool Bodies::hides(const Hit& hit, const Hit& of_room) const {
  if (hit.facet < 0) return false;
  return hit.facet >= moving_ || of_room.facet < 0 || hit.distance < of_room.distance;
}

Color Bodies::light_of(const Ray& ray, const Hit& hit, double pixel_rad) const {
  const Facet& seen = bodies_.facets[static_cast<std::size_t>(hit.facet)];
  const Surface& surface = bodies_.surfaces[static_cast<std::size_t>(seen.surface)];
  // Light from all sides, more of it from above.
  const float light = kMeanLight * static_cast<float>(0.8 + 0.2 * seen.normal.y());
  return light * seen_albedo(seen, surface, ray, hit.distance, hit.distance * pixel_rad);
}

const Facet& VirtualRoom::facet(const Hit& hit) const {
  return scene_.room.facets[static_cast<std::size_t>(hit.facet)];
}

const Surface& VirtualRoom::surface_of(const Facet& facet) const {
  return scene_.room.surfaces[static_cast<std::size_t>(facet.surface)];
}

Color VirtualRoom::look(const Ray& ray, double pixel_rad, const Bodies* bodies) const {
  const Hit of_room = solids_.intersect(ray);
  const Hit of_body = bodies != nullptr ? bodies->intersect(ray) : Hit{};
  const bool is_body = bodies != nullptr && bodies->hides(of_body, of_room);
  Color seen =
      is_body ? bodies->light_of(ray, of_body, pixel_rad) : light_of(ray, of_room, 0.0, pixel_rad);
  if (!glass_) return seen;
  return through_glass(ray, distance_of(is_body ? of_body : of_room), seen, pixel_rad);
}

double VirtualRoom::measure(const Ray& ray) const {
  const Hit hit = solids_.intersect(ray);
  const bool is_far = hit.facet < 0 || surface_of(facet(hit)).pattern == Pattern::kSky;
  return is_far ? std::numeric_limits<double>::infinity() : hit.distance;
}

// Inside a solid, rays in all directions hit back faces. A single back face may be a ray that
// grazes an edge.
bool VirtualRoom::is_inside_solid(const Vector3d& place) const {
  constexpr int kLooks = 64;
  int backs = 0;
  for (int i = 0; i < kLooks; ++i) {
    const Vector3d direction = spread_direction(i, kLooks);
    const Hit hit = solids_.intersect(Ray{place, direction});
    if (hit.facet < 0) continue;
    if (!facet(hit).two_sided && facet(hit).normal.dot(direction) > 0.0) ++backs;
  }
  return backs > kLooks / 4;
}

Color VirtualRoom::light_of(const Ray& ray, const Hit& hit, double travelled,
                            double pixel_rad) const {
  if (hit.facet >= 0 && surface_of(facet(hit)).pattern == Pattern::kMirror) {
    return reflection(ray, hit, travelled, pixel_rad);
  }
  return diffuse_light(ray, hit, travelled, pixel_rad);
}

// There is a single flat mirror, so one reflection suffices. It shows neither panes nor bodies.
Color VirtualRoom::reflection(const Ray& ray, const Hit& hit, double travelled,
                              double pixel_rad) const {
  const Ray reflected = reflected_ray(ray, hit.distance, facet(hit).normal);
  const Hit seen = solids_.intersect(reflected);
  return kMirrorReflectance * diffuse_light(reflected, seen, travelled + hit.distance, pixel_rad);
}

// Each pane mixes what it reflects with what is behind it.
Color VirtualRoom::through_glass(const Ray& ray, double distance, const Color& seen,
                                 double pixel_rad) const {
  Color sum = Color::Zero();
  float passed = 1.0F;
  double travelled = 0.0;
  Ray rest = ray;
  for (Hit pane = glass_->intersect(rest); pane.facet >= 0 && travelled + pane.distance < distance;
       pane = glass_->intersect(rest)) {
    const Vector3d& normal = scene_.glass[static_cast<std::size_t>(pane.facet)].normal;
    const float share = pane_reflectance(std::abs(normal.dot(ray.direction)));
    const Ray reflected = reflected_ray(
        rest, pane.distance, normal.dot(ray.direction) < 0.0 ? normal : Vector3d(-normal));
    travelled += pane.distance + kOffMirror;
    sum += passed * share * light_of(reflected, solids_.intersect(reflected), travelled, pixel_rad);
    passed *= 1.0F - share;
    rest.origin = ray.origin + travelled * ray.direction;
  }
  return sum + passed * seen;
}

Color VirtualRoom::diffuse_light(const Ray& ray, const Hit& hit, double travelled,
                                 double pixel_rad) const {
  if (hit.facet < 0 || surface_of(facet(hit)).pattern == Pattern::kSky) {
    return static_cast<float>(settings_.light.source_gain) *
           sky_light(ray.direction, static_cast<float>(pixel_rad), scene_.lights.sky_seed);
  }
  const Facet& seen = facet(hit);
  const Surface& surface = surface_of(seen);
  const double facing = seen.normal.dot(ray.direction);
  const Vector3d point = ray.origin + hit.distance * ray.direction;
  const Color albedo =
      seen_albedo(seen, surface, ray, hit.distance, (travelled + hit.distance) * pixel_rad);
  if (surface.pattern == Pattern::kLamp)
    return static_cast<float>(settings_.light.source_gain) * albedo;
  const Vector3d normal = seen.two_sided && facing > 0.0 ? Vector3d(-seen.normal) : seen.normal;
  return albedo.cwiseProduct(light_map_.at(hit, point, normal));
}

}  // namespace raywalk::simulator
