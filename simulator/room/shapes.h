// The geometry of a room: planar quadrilateral facets, each with its surface and texture frame, and
// solids made of them. Lengths are in metres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "simulator/room/surface.h"

namespace raywalk::simulator {

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

// Rotation by yaw (as Attitude::yaw_rad) and translation to `origin`.
struct Placement {
  Eigen::Vector3d origin{0, 0, 0};
  double yaw_rad = 0.0;

  Eigen::Matrix3d rotation() const;
  Eigen::Vector3d direction(const Eigen::Vector3d& local) const { return rotation() * local; }
  Eigen::Vector3d point(const Eigen::Vector3d& local) const { return origin + direction(local); }
};

// A convex quadrilateral whose corners are, seen from its front, at the bottom left, bottom right,
// top right and top left. Texture coordinates start at the first: s to the right, t upwards. The
// last two corners may coincide.
Facet make_quad(const std::array<Eigen::Vector3d, 4>& corners, int surface);

// A box between two opposite corners in the local frame. On every side the texture's s axis is
// along the longer edge, so that grain follows a beam.
void add_box(const Placement& place, const Eigen::Vector3d& min, const Eigen::Vector3d& max,
             int surface, std::vector<Facet>* facets);

// The same without its side towards -z, to hang on a wall. Its front is towards +z; textures are
// upright, s to the right as seen from the front.
void add_panel(const Placement& place, const Eigen::Vector3d& min, const Eigen::Vector3d& max,
               int surface, std::vector<Facet>* facets);

// A conical frustum between two points with a radius at each end, and flat caps.
struct Rod {
  Eigen::Vector3d from{0, 0, 0};
  Eigen::Vector3d to{0, 1, 0};
  double from_radius = 0.02;
  double to_radius = 0.02;
};
void add_rod(const Placement& place, const Rod& rod, int surface, std::vector<Facet>* facets);

// A spheroid around `centre` with the semi-axis `half_height` along y.
void add_globe(const Eigen::Vector3d& centre, double radius, double half_height, int surface,
               std::vector<Facet>* facets);

}  // namespace raywalk::simulator
