// Selects, per direction, the stations to compare with a reference.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace raywalk::build_lf {

// Number of baselines on each side of the reference, spread evenly up to the reach: short ones
// suffer less from occlusion, long ones resolve distances better.
inline constexpr int kViewsPerSide = 4;

struct MatchingGeometry {
  Eigen::Vector3d reference_m{0, 0, 0};
  Eigen::Vector3d rail{1, 0, 0};  // unit vector along the reference's line
  double reach_m = 0.0;           // the longest baseline, metres
};

// Indices into `stations_m`, by side of the reference: what a near edge hides from the stations on
// one side is usually visible from the other.
struct MatchingViews {
  std::array<std::vector<int>, 2> side;
};

// The stations to compare in `direction` (a unit vector). With t the vector from the reference to a
// station, the parallax of a point at inverse distance w is |t x direction| w: only the
// component of t perpendicular to the direction matters. Along the rail the line's own stations
// have none, so stations of intersecting lines are used there. The component along the direction
// only changes the scale, and is kept small. Stations far ahead are excluded, as they may lie
// behind the surface.
MatchingViews choose_matching_views(const MatchingGeometry& geometry,
                                    const Eigen::Vector3d& direction,
                                    std::span<const Eigen::Vector3d> stations_m);

}  // namespace raywalk::build_lf
