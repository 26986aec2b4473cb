// Solids made of facets. Lengths are in room units; `place` puts a piece of furniture, drawn around
// its own origin on the floor, where it stands.
#pragma once

#include <Eigen/Geometry>

#include "capture/simulated/virtual_room/facets.h"

namespace raywalk::capture {

// Turns by yaw (as Attitude::yaw_rad does) and moves to `origin`.
struct Placement {
  Eigen::Vector3d origin{0, 0, 0};
  double yaw_rad = 0.0;

  Eigen::Vector3d direction(const Eigen::Vector3d& local) const;
  Eigen::Vector3d point(const Eigen::Vector3d& local) const { return origin + direction(local); }
};

// A rectangle from `corner` along two perpendicular edges. Texture coordinates count from the
// corner, s along edge_s and t along edge_t. Its front is where `normal` points.
Facet make_rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge_s,
                     const Eigen::Vector3d& edge_t, const Eigen::Vector3d& normal, int surface);

// A box between two opposite corners in the placement's axes. On every side the texture's s axis
// runs along the longer edge, so that grain follows a beam.
void add_box(const Placement& place, const Eigen::Vector3d& min, const Eigen::Vector3d& max,
             int surface, Facets* facets);

// A round rod between two points with a radius at either end, and flat caps.
struct Rod {
  Eigen::Vector3d from{0, 0, 0};
  Eigen::Vector3d to{0, 1, 0};
  double from_radius = 0.02;
  double to_radius = 0.02;
};
void add_rod(const Placement& place, const Rod& rod, int surface, Facets* facets);

// A ball around `centre`, stretched to `half_height` along y.
void add_globe(const Eigen::Vector3d& centre, double radius, double half_height, int surface,
               Facets* facets);

}  // namespace raywalk::capture
