#include "simulator/room/shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector3d;

constexpr int kRodSides = 12;  // even, so that the caps divide into quadrilaterals
constexpr int kGlobeMeridians = 32;
constexpr int kGlobeParallels = 16;

// A unit vector perpendicular to `axis`, from the coordinate axis that is least aligned with it.
Vector3d any_perpendicular(const Vector3d& axis) {
  int least = 0;
  axis.cwiseAbs().minCoeff(&least);
  return axis.cross(Vector3d::Unit(least)).normalized();
}

// Points of a circle around an end of the rod, with outward normals.
struct Ring {
  std::array<Vector3d, kRodSides> points;
  std::array<Vector3d, kRodSides> outward;
};

Ring ring_around(const Vector3d& centre, const Vector3d& across, const Vector3d& other,
                 double radius) {
  Ring ring;
  for (std::size_t i = 0; i < kRodSides; ++i) {
    const double turn = kTwoPi * static_cast<double>(i) / kRodSides;
    ring.outward[i] = across * std::cos(turn) + other * std::sin(turn);
    ring.points[i] = centre + radius * ring.outward[i];
  }
  return ring;
}

// The plane's normal on the side of `hint`, from the diagonals, which are not parallel even if two
// corners coincide.
Vector3d plane_normal(const std::array<Vector3d, 4>& corners, const Vector3d& hint) {
  const Vector3d normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalized();
  return normal.dot(hint) < 0.0 ? Vector3d(-normal) : normal;
}

void add_cap(const Ring& ring, const Vector3d& outward, int surface, std::vector<Facet>* facets) {
  for (std::size_t i = 1; i + 2 < kRodSides; i += 2) {
    Facet cap;
    cap.corners = {ring.points[0], ring.points[i], ring.points[i + 1], ring.points[i + 2]};
    cap.corner_normals.fill(outward);
    cap.normal = outward;
    const Vector3d s_axis = (ring.points[kRodSides / 2] - ring.points[0]).normalized();
    cap.texture = {ring.points[0], s_axis, outward.cross(s_axis), {0, 0}};
    cap.surface = surface;
    facets->push_back(cap);
  }
}

// A rectangle of the local frame from `corner` along two perpendicular edges, which are the axes of
// its texture.
Facet make_rectangle(const Placement& place, const Vector3d& corner, const Vector3d& edge_s,
                     const Vector3d& edge_t, const Vector3d& normal, int surface) {
  const Vector3d at = place.point(corner);
  const Vector3d s = place.direction(edge_s), t = place.direction(edge_t);
  Facet facet;
  facet.corners = {at, at + s, at + s + t, at + t};
  facet.normal = place.direction(normal);
  facet.corner_normals.fill(facet.normal);
  facet.texture = {at, s.normalized(), t.normalized(), {0, 0}};
  facet.surface = surface;
  return facet;
}

Vector3d globe_point(int meridian, int parallel, double half_height_per_radius) {
  const Vector3d unit = direction_from_angles(
      {kTwoPi * meridian / kGlobeMeridians - kPi, kPi * parallel / kGlobeParallels - kHalfPi});
  return {unit.x(), unit.y() * half_height_per_radius, unit.z()};
}

}  // namespace

Facet moved(Facet facet, const Eigen::Matrix3d& rotation, const Vector3d& origin) {
  for (Vector3d& corner : facet.corners) corner = rotation * corner + origin;
  for (Vector3d& normal : facet.corner_normals) normal = rotation * normal;
  facet.normal = rotation * facet.normal;
  facet.texture.origin = rotation * facet.texture.origin + origin;
  facet.texture.s_axis = rotation * facet.texture.s_axis;
  facet.texture.t_axis = rotation * facet.texture.t_axis;
  return facet;
}

Eigen::Matrix3d Placement::rotation() const { return world_from_camera({yaw_rad, 0.0, 0.0}); }

Facet make_quad(const std::array<Vector3d, 4>& corners, int surface) {
  Facet facet;
  facet.corners = corners;
  // y is up and z away from the viewer, so the frame is left-handed.
  facet.normal = (corners[3] - corners[1]).cross(corners[2] - corners[0]).normalized();
  facet.corner_normals.fill(facet.normal);
  const Vector3d s_axis = (corners[1] - corners[0]).normalized();
  facet.texture = {corners[0], s_axis, s_axis.cross(facet.normal), {0, 0}};
  facet.surface = surface;
  return facet;
}

void add_box(const Placement& place, const Vector3d& min, const Vector3d& max, int surface,
             std::vector<Facet>* facets) {
  const Vector3d size = max - min;
  for (int axis = 0; axis < 3; ++axis) {
    int longer = (axis + 1) % 3, shorter = (axis + 2) % 3;
    if (size[longer] < size[shorter]) std::swap(longer, shorter);
    const Vector3d s = size[longer] * Vector3d::Unit(longer);
    const Vector3d t = size[shorter] * Vector3d::Unit(shorter);
    for (const bool upper : {false, true}) {
      const Vector3d corner = upper ? Vector3d(min + size[axis] * Vector3d::Unit(axis)) : min;
      const Vector3d normal = (upper ? 1.0 : -1.0) * Vector3d::Unit(axis);
      facets->push_back(make_rectangle(place, corner, s, t, normal, surface));
    }
  }
}

void add_panel(const Placement& place, const Vector3d& min, const Vector3d& max, int surface,
               std::vector<Facet>* facets) {
  const Vector3d right = -Vector3d::UnitX(), up = Vector3d::UnitY(), out = Vector3d::UnitZ();
  const Vector3d s = (max.x() - min.x()) * right, t = (max.y() - min.y()) * up;
  const Vector3d d = (max.z() - min.z()) * out;
  const Vector3d near(max.x(), min.y(), min.z()), far = near + s + t + d;
  facets->push_back(make_rectangle(place, near + d, s, t, out, surface));
  facets->push_back(make_rectangle(place, near, d, t, -right, surface));
  facets->push_back(make_rectangle(place, far, -d, -t, right, surface));
  facets->push_back(make_rectangle(place, near, s, d, -up, surface));
  facets->push_back(make_rectangle(place, far, -s, -d, up, surface));
}

void add_rod(const Placement& place, const Rod& rod, int surface, std::vector<Facet>* facets) {
  const Vector3d from = place.point(rod.from), to = place.point(rod.to);
  const Vector3d axis = (to - from).normalized();
  const Vector3d across = any_perpendicular(axis), other = axis.cross(across);
  const Ring lower = ring_around(from, across, other, rod.from_radius);
  const Ring upper = ring_around(to, across, other, rod.to_radius);
  const double radius = std::max(rod.from_radius, rod.to_radius);
  for (std::size_t i = 0; i < kRodSides; ++i) {
    const std::size_t next = (i + 1) % kRodSides;
    Facet side;
    side.corners = {lower.points[i], upper.points[i], upper.points[next], lower.points[next]};
    side.corner_normals = {lower.outward[i], upper.outward[i], upper.outward[next],
                           lower.outward[next]};
    side.normal = plane_normal(side.corners, lower.outward[i] + lower.outward[next]);
    // s runs along the rod, t around it, so that the pattern is continuous between sides.
    const Vector3d around = (lower.outward[next] - lower.outward[i]).normalized();
    const double turned = kTwoPi * static_cast<double>(i) / kRodSides * radius;
    side.texture = {lower.points[i] - turned * around, axis, around, {0, 0}};
    side.surface = surface;
    facets->push_back(side);
  }
  add_cap(lower, -axis, surface, facets);
  add_cap(upper, axis, surface, facets);
}

void add_globe(const Vector3d& centre, double radius, double half_height, int surface,
               std::vector<Facet>* facets) {
  const double stretch = half_height / radius;
  for (int parallel = 0; parallel < kGlobeParallels; ++parallel) {
    for (int meridian = 0; meridian < kGlobeMeridians; ++meridian) {
      // At the north pole the last two corners coincide, as they may; at the south pole the order
      // is rotated so that it is the last two as well.
      const int first = parallel == 0 ? 1 : 0;
      const std::array<Vector3d, 4> units = {
          globe_point(meridian, parallel + first, stretch),
          globe_point(meridian + 1, parallel + first, stretch),
          globe_point(meridian + 1, parallel + 1 - first, stretch),
          globe_point(meridian, parallel + 1 - first, stretch)};
      Facet facet;
      for (std::size_t i = 0; i < 4; ++i) {
        facet.corners[i] = centre + radius * units[i];
        // The gradient of x^2 + (y / stretch)^2 + z^2.
        facet.corner_normals[i] =
            Vector3d(units[i].x(), units[i].y() / (stretch * stretch), units[i].z()).normalized();
      }
      facet.normal = plane_normal(facet.corners, facet.corner_normals[0]);
      facet.texture = {
          centre, (facet.corners[1] - facet.corners[0]).normalized(), Vector3d::UnitY(), {0, 0}};
      facet.surface = surface;
      facets->push_back(facet);
    }
  }
}

}  // namespace raywalk::simulator
