// Which stations are compared with a reference, direction by direction.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace raywalk::build_lf {

// Stations on each side of the reference are compared at so many baselines, spread evenly up to the
// reach: short ones see what is near and hides, long ones tell distances apart.
inline constexpr int kViewsPerSide = 4;

struct MatchingGeometry {
  Eigen::Vector3d reference_m{0, 0, 0};
  Eigen::Vector3d rail{1, 0, 0};  // unit vector along the reference's line
  double reach_m = 0.0;           // the longest baseline aimed at
};

// Indices into the stations offered. What a near edge hides from the stations on one side, those on
// the other side see.
struct MatchingViews {
  std::array<std::vector<int>, 2> side;
};

// The stations to compare in `direction` (a unit vector). With t the way from the reference to a
// station, the parallax of a point at inverse distance omega is |t x direction| omega: only the
// part of t perpendicular to the direction counts. A line's own stations have none along their
// rail, and there stations of the lines that cross it are taken. The part along the direction only
// changes the scale, and is kept small. Stations so far ahead that they may lie behind what is seen
// are left out.
MatchingViews choose_matching_views(const MatchingGeometry& geometry,
                                    const Eigen::Vector3d& direction,
                                    std::span<const Eigen::Vector3d> stations_m);

}  // namespace raywalk::build_lf
