#include "simulator/room/light_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/base/parallel.h"
#include "core/geometry/sphere.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector3d;

constexpr float kSunPerMeanLight = 2.6F;
constexpr double kLargestGrid = 64.0;
constexpr int kWindowSamples = 6;  // per side
// Irradiance close to the pane is up to pi, far beyond white at the room's exposure, and
// undersampled there.
constexpr double kMostWindowLight = 0.5;
constexpr int kBounceRays = 64;
constexpr double kSkyReach = 1e3;  // nothing is farther than this but the sky
constexpr int kGrain = 256;
// Offset of ray origins from their surface. On the shell it exceeds the thickness of objects that
// hang flat on walls, which would otherwise darken the grid points behind them and, by
// interpolation, their surroundings.
constexpr double kOffSurface = 1e-3;
constexpr double kOffShell = 0.04;

const Color kSkyTint(0.93F, 0.99F, 1.08F);
const Color kLampTint(1.9F, 1.6F, 1.2F);  // a lamp is brighter than the window, and warmer
const Color kAmbient(0.035F, 0.035F, 0.035F);

// Point at Embree's (u, v), linear on the triangles 0-1-3 and 2-3-1.
Vector3d interpolated(const std::array<Vector3d, 4>& corners, double u, double v) {
  if (u + v <= 1.0) {
    return corners[0] + u * (corners[1] - corners[0]) + v * (corners[3] - corners[0]);
  }
  return corners[2] + (1.0 - u) * (corners[3] - corners[2]) + (1.0 - v) * (corners[1] - corners[2]);
}

int grid_size(double length, double step) {
  return static_cast<int>(std::clamp(std::ceil(length / step) + 1.0, 2.0, kLargestGrid));
}

// A point of the light grid, offset from its surface.
struct GridPoint {
  Vector3d position;
  Vector3d normal;
};

GridPoint grid_point(const Facet& facet, int column, int row, int columns, int rows) {
  // A corner is shared with neighbouring facets, so the grid ends a little before it.
  constexpr double kMargin = 0.02;
  const double u = kMargin + (1.0 - 2.0 * kMargin) * column / (columns - 1);
  const double v = kMargin + (1.0 - 2.0 * kMargin) * row / (rows - 1);
  const Vector3d normal = interpolated(facet.corner_normals, u, v).normalized();
  const double off = facet.shell ? kOffShell : kOffSurface;
  return {interpolated(facet.corners, u, v) + off * facet.normal, normal};
}

Color window_light(const WindowLight& window, const GridPoint& at, const EmbreeScene& scene) {
  const double area = window.edge_s.norm() * window.edge_t.norm();
  double sum = 0.0;
  for (int i = 0; i < kWindowSamples; ++i) {
    for (int j = 0; j < kWindowSamples; ++j) {
      const Vector3d towards = window.corner + (i + 0.5) / kWindowSamples * window.edge_s +
                               (j + 0.5) / kWindowSamples * window.edge_t - at.position;
      const double distance = towards.norm();
      const Vector3d direction = towards / distance;
      const double from = at.normal.dot(direction), to = -window.inward.dot(direction);
      if (from <= 0.0 || to <= 0.0) continue;
      if (scene.occluded({at.position, direction}, distance - kOffSurface)) continue;
      sum += from * to / (distance * distance);
    }
  }
  const double light = sum * area / (kWindowSamples * kWindowSamples);
  return kSkyTint * static_cast<float>(std::min(light, kMostWindowLight));
}

// Irradiance of a sphere of radiance L that is entirely above the horizon: pi L R^2 cos / r^2.
Color lamp_light(const LampLight& lamp, double reach, const GridPoint& at,
                 const EmbreeScene& scene) {
  const Vector3d towards = lamp.centre - at.position;
  const double distance = towards.norm();
  if (distance > reach) return Color::Zero();
  const Vector3d direction = towards / distance;
  const double cosine = at.normal.dot(direction);
  const double free = distance - 1.05 * lamp.radius;
  if (cosine <= 0.0 || free <= 0.0) return Color::Zero();
  if (scene.occluded({at.position, direction}, free)) return Color::Zero();
  return kLampTint *
         static_cast<float>(kPi * lamp.radius * lamp.radius * cosine / (distance * distance));
}

// Cosine-weighted direction number `index`: a Hammersley set on the disc, projected onto the
// hemisphere (Malley's method) and rotated by `turn`.
Vector3d bounce_direction(int index, double turn, const Vector3d& normal) {
  double radical_inverse = 0.0, digit = 0.5;
  for (int bits = index; bits > 0; bits /= 2, digit *= 0.5) radical_inverse += bits % 2 * digit;
  const double square = (index + 0.5) / kBounceRays;
  const double angle = kTwoPi * (radical_inverse + turn);
  const Vector3d seed_axis = std::abs(normal.y()) < 0.9 ? Vector3d::UnitY() : Vector3d::UnitX();
  const Vector3d across = normal.cross(seed_axis).normalized(), other = normal.cross(across);
  return std::sqrt(square) * (std::cos(angle) * across + std::sin(angle) * other) +
         std::sqrt(1.0 - square) * normal;
}

// Irradiance of a uniform sky where it is not hidden.
Color open_sky_light(const GridPoint& at, double turn, const EmbreeScene& scene) {
  int open = 0;
  for (int ray = 0; ray < kBounceRays; ++ray) {
    const Vector3d direction = bounce_direction(ray, turn, at.normal);
    if (direction.y() > 0.0 && !scene.occluded({at.position, direction}, kSkyReach)) ++open;
  }
  return kSkyTint * (static_cast<float>(open) / kBounceRays);
}

}  // namespace

LightMap::LightMap(const Facets& facets, const EmbreeScene& scene, const LightSources& lights)
    : scene_(scene), lights_(lights) {
  std::size_t points = 0;
  for (const Facet& facet : facets.facets) {
    Grid grid;
    grid.first = points;
    grid.columns = grid_size((facet.corners[1] - facet.corners[0]).norm(), lights.grid_step);
    grid.rows = grid_size((facet.corners[3] - facet.corners[0]).norm(), lights.grid_step);
    grids_.push_back(grid);
    points += static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
  }
  light_.assign(points, Color::Zero());
  light_directly(facets);
  add_bounce(facets);
  expose(facets);
}

template <typename Point>
void LightMap::for_each_point(const Facets& facets, const Point& point) const {
  parallel_for(0, static_cast<int>(grids_.size()), kGrain, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Grid& grid = grids_[static_cast<std::size_t>(i)];
      const Facet& facet = facets.facets[static_cast<std::size_t>(i)];
      for (int number = 0; number < grid.columns * grid.rows; ++number) {
        point(grid.first + static_cast<std::size_t>(number),
              grid_point(facet, number % grid.columns, number / grid.columns, grid.columns,
                         grid.rows));
      }
    }
  });
}

void LightMap::light_directly(const Facets& facets) {
  for_each_point(facets, [&](std::size_t index, const GridPoint& at) {
    Color light = kAmbient;
    for (const WindowLight& window : lights_.windows) light += window_light(window, at, scene_);
    for (const LampLight& lamp : lights_.lamps) {
      light += lamp_light(lamp, lights_.lamp_reach, at, scene_);
    }
    if (lights_.open_sky) {
      light += open_sky_light(at, uniform_from_bits(hash_bits(index)), scene_);
    }
    light_[index] = light;
  });
}

void LightMap::add_bounce(const Facets& facets) {
  std::vector<Color> reflectance;
  reflectance.reserve(facets.surfaces.size());
  for (const Surface& surface : facets.surfaces) reflectance.push_back(mean_albedo(surface));
  std::vector<Color> bounced(light_.size());
  for_each_point(facets, [&](std::size_t index, const GridPoint& at) {
    const double turn = uniform_from_bits(hash_bits(index));
    Color sum = Color::Zero();
    for (int i = 0; i < kBounceRays; ++i) {
      const Ray ray{at.position, bounce_direction(i, turn, at.normal)};
      const Hit hit = scene_.intersect(ray);
      if (hit.facet < 0) continue;
      const Facet& from = facets.facets[static_cast<std::size_t>(hit.facet)];
      const auto surface = static_cast<std::size_t>(from.surface);
      if (facets.surfaces[surface].pattern == Pattern::kLamp) continue;  // counted as a light
      // A back face: the point is inside a solid.
      if (!from.two_sided && from.normal.dot(ray.direction) > 0.0) continue;
      sum += reflectance[surface].cwiseProduct(interpolate(hit));
    }
    bounced[index] = sum / kBounceRays;
  });
  for (std::size_t i = 0; i < light_.size(); ++i) light_[i] += bounced[i];
}

void LightMap::expose(const Facets& facets) {
  const bool has_shell = std::ranges::any_of(facets.facets, &Facet::shell);
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < grids_.size(); ++i) {
    if (has_shell && !facets.facets[i].shell) continue;
    const auto points =
        static_cast<std::size_t>(grids_[i].columns) * static_cast<std::size_t>(grids_[i].rows);
    for (std::size_t point = 0; point < points; ++point) {
      sum += static_cast<double>(luminance(light_[grids_[i].first + point]));
    }
    count += static_cast<double>(points);
  }
  const float gain = kMeanLight * static_cast<float>(count / sum);
  for (Color& light : light_) light *= gain;
  if (lights_.sun) sun_ = kSunPerMeanLight * kMeanLight;
}

Color LightMap::interpolate(const Hit& hit) const {
  const Grid& grid = grids_[static_cast<std::size_t>(hit.facet)];
  const float x = std::clamp(hit.u, 0.0F, 1.0F) * static_cast<float>(grid.columns - 1);
  const float y = std::clamp(hit.v, 0.0F, 1.0F) * static_cast<float>(grid.rows - 1);
  const int column = std::min(static_cast<int>(x), grid.columns - 2);
  const int row = std::min(static_cast<int>(y), grid.rows - 2);
  const float fx = x - static_cast<float>(column), fy = y - static_cast<float>(row);
  const Color* corner = light_.data() + grid.first + row * grid.columns + column;
  return mix(mix(corner[0], corner[1], fx), mix(corner[grid.columns], corner[grid.columns + 1], fx),
             fy);
}

bool LightMap::is_sunlit(const Vector3d& point, const Vector3d& normal) const {
  const Ray towards{point + kOffSurface * normal, *lights_.sun};
  if (lights_.open_sky) return !scene_.occluded(towards, kSkyReach);
  return std::ranges::any_of(lights_.windows, [&](const WindowLight& window) {
    const double approach = -window.inward.dot(*lights_.sun);
    if (approach <= 0.0) return false;
    const double distance = window.inward.dot(point - window.corner) / approach;
    const Vector3d on_pane = point + distance * *lights_.sun - window.corner;
    const double s = on_pane.dot(window.edge_s) / window.edge_s.squaredNorm();
    const double t = on_pane.dot(window.edge_t) / window.edge_t.squaredNorm();
    if (s < 0.0 || s > 1.0 || t < 0.0 || t > 1.0 || distance < kOffSurface) return false;
    return !scene_.occluded(towards, distance - 2.0 * kOffSurface);
  });
}

float LightMap::sunlight(const Vector3d& point, const Vector3d& normal) const {
  const double cosine = normal.dot(*lights_.sun);
  if (cosine <= 0.0 || !is_sunlit(point, normal)) return 0.0F;
  return sun_ * static_cast<float>(cosine);
}

Color LightMap::at(const Hit& hit, const Vector3d& point, const Vector3d& normal) const {
  Color light = interpolate(hit);
  if (lights_.sun) light += Color(1.05F, 1.0F, 0.9F) * sunlight(point, normal);
  return light;
}

}  // namespace raywalk::simulator
