// The geometry of a room: planar quadrilateral facets, each with its surface and texture frame.
// Lengths are in metres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "simulator/room/surface.h"

namespace raywalk::capture {

// Texture coordinates of a facet: a point p has
// ((p - origin) . s_axis, (p - origin) . t_axis) + at_origin.
struct TextureFrame {
  Eigen::Vector3d origin{0, 0, 0};
  Eigen::Vector3d s_axis{1, 0, 0};  // unit vectors, except on a mesh with texture coordinates
  Eigen::Vector3d t_axis{0, 1, 0};
  Eigen::Vector2d at_origin{0, 0};
};

// The corners are coplanar and go around a convex quadrilateral; the last two may coincide, which
// gives a triangle.
struct Facet {
  std::array<Eigen::Vector3d, 4> corners;
  // Normals at the corners of the curved surface that the facet approximates, for shading.
  std::array<Eigen::Vector3d, 4> corner_normals;
  Eigen::Vector3d normal;  // unit normal of the plane, pointing out of the solid
  TextureFrame texture{};
  int surface = 0;         // index into Facets::surfaces
  bool two_sided = false;  // visible from both sides, as a leaf
  bool shell = false;      // a wall, the floor or the ceiling, which the exposure is made for
};

struct Facets {
  std::vector<Surface> surfaces{};
  std::vector<Facet> facets{};
};

// The facet in another frame: every point p becomes rotation * p + origin.
Facet moved(Facet facet, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& origin);

}  // namespace raywalk::capture
