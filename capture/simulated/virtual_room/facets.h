// The geometry of a room: flat four-sided facets, each with its surface and texture frame.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "capture/simulated/virtual_room/surface.h"

namespace raywalk::capture {

// The plane coordinates in which a facet's pattern is drawn: of a point p they are
// ((p - origin) . s_axis, (p - origin) . t_axis).
struct TextureFrame {
  Eigen::Vector3d origin{0, 0, 0};
  Eigen::Vector3d s_axis{1, 0, 0};  // unit vectors
  Eigen::Vector3d t_axis{0, 1, 0};
};

// Room units. The corners lie in a plane and go around a convex rim; the last two may coincide,
// which leaves a triangle.
struct Facet {
  std::array<Eigen::Vector3d, 4> corners;
  // Of the curved surface that the facet approximates, at its corners; light is computed with them.
  std::array<Eigen::Vector3d, 4> corner_normals;
  Eigen::Vector3d normal;  // unit vector of the plane, out of the solid and into the room
  TextureFrame texture{};
  int surface = 0;          // index into Facets::surfaces
  bool two_sided = false;   // thin enough to be seen from both sides, as a leaf is
  bool room_shell = false;  // a wall, the floor or the ceiling
};

struct Facets {
  std::vector<Surface> surfaces;
  std::vector<Facet> facets;

  // The index of the new surface.
  int add_surface(const Surface& surface);
};

}  // namespace raywalk::capture
