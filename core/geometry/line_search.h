// Groups plan positions into straight lines along x and z. Internal to find_grid (grid.h).
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/plan_line.h"

namespace raywalk {

// Tangent of the largest angle between a line and its axis, 3 degrees; a slider placed by eye is
// within 2.
inline constexpr double kMaxObliqueness = 0.0524077792830412;

// A line and the stations (indices of positions) on it, in order along it.
struct LineGroup {
  PlanLine line;
  std::vector<int> stations;
};

// Lines with at least two of the positions each, within `tolerance_m` of them. A station where
// lines cross is on one of each axis; none is on two of one axis. Some may be on none. The order of
// the positions does not matter.
std::vector<LineGroup> find_lines(std::span<const Eigen::Vector2d> points, double tolerance_m);

// Leaves every station on one line:
// - Of two where lines cross, one on each. The order of the list tells which, if their neighbours
//   in it are on one of the lines, as a line is captured station by station; else the distance.
// - One where lines cross stays on the line that ends there, else on that with the wider gap.
// A line that has less than two stations of its own is a chance row of stations of others: it is
// dropped. `twin_m`: the distance within which two stations are not of one line.
void share_out_crossings(std::span<const Eigen::Vector2d> points, double twin_m,
                         std::vector<LineGroup>* lines);

}  // namespace raywalk
