// Solids made of facets. Lengths are in room units; `place` transforms from the local frame of a
// piece of furniture, whose origin is on the floor.
#pragma once

#include <Eigen/Geometry>

#include "simulator/room/facets.h"

namespace raywalk::capture {

// Rotation by yaw (as Attitude::yaw_rad) and translation to `origin`.
struct Placement {
  Eigen::Vector3d origin{0, 0, 0};
  double yaw_rad = 0.0;

  Eigen::Vector3d direction(const Eigen::Vector3d& local) const;
  Eigen::Vector3d point(const Eigen::Vector3d& local) const { return origin + direction(local); }
};

// A rectangle from `corner` along two perpendicular edges. Texture coordinates start at the corner,
// s along edge_s and t along edge_t. `normal` points to its front.
Facet make_rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge_s,
                     const Eigen::Vector3d& edge_t, const Eigen::Vector3d& normal, int surface);

// A box between two opposite corners in the local frame. On every side the texture's s axis is
// along the longer edge, so that grain follows a beam.
void add_box(const Placement& place, const Eigen::Vector3d& min, const Eigen::Vector3d& max,
             int surface, Facets* facets);

// A conical frustum between two points with a radius at each end, and flat caps.
struct Rod {
  Eigen::Vector3d from{0, 0, 0};
  Eigen::Vector3d to{0, 1, 0};
  double from_radius = 0.02;
  double to_radius = 0.02;
};
void add_rod(const Placement& place, const Rod& rod, int surface, Facets* facets);

// A spheroid around `centre` with the semi-axis `half_height` along y.
void add_globe(const Eigen::Vector3d& centre, double radius, double half_height, int surface,
               Facets* facets);

}  // namespace raywalk::capture
