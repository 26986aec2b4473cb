// Straight lines of the plan: their fit, and for find_grid (grid.h) the search for them.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "core/geometry/grid.h"

namespace raywalk {

// A line of the plan; plan vectors are (x, z) in metres. `direction` is a unit vector with a
// positive component along `axis`.
struct PlanLine {
  LineAxis axis = LineAxis::kX;
  Eigen::Vector2d origin{0, 0};
  Eigen::Vector2d direction{1, 0};

  double along(const Eigen::Vector2d& point) const { return (point - origin).dot(direction); }
  // Unsigned distance of a point from the line, metres.
  double distance_to(const Eigen::Vector2d& point) const {
    const Eigen::Vector2d from = point - origin;
    return std::abs(direction.x() * from.y() - direction.y() * from.x());
  }
};

// The coordinate of a plan vector (x, z) that grows along an axis.
inline int along_index(LineAxis axis) { return axis == LineAxis::kX ? 0 : 1; }

// Least-squares line (orthogonal residuals) through at least two points, of those whose angle to
// the axis has at most the tangent `most_oblique`: few stations beside their line say little about
// its direction. The origin is the points' centroid.
PlanLine fit_line(std::span<const Eigen::Vector2d> points, LineAxis axis,
                  double most_oblique = std::numeric_limits<double>::infinity());

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
void share_out_intersections(std::span<const Eigen::Vector2d> points, double twin_m,
                             std::vector<LineGroup>* lines);

}  // namespace raywalk
