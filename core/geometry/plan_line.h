// Straight lines of the plan and their fit. Internal to find_grid (grid.h).
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/geometry/grid.h"
#include "core/geometry/station_tree.h"

namespace raywalk {

// A line of the plan; plan vectors are (x, z) in metres. `direction` is a unit vector with a
// positive component along `axis`.
struct PlanLine {
  LineAxis axis = LineAxis::kX;
  Eigen::Vector2d origin{0, 0};
  Eigen::Vector2d direction{1, 0};

  double along(const Eigen::Vector2d& point) const { return (point - origin).dot(direction); }
  // Unsigned distance of a point from the line, metres.
  double distance_to(const Eigen::Vector2d& point) const;
  // Whether the box may hold a point within `limit_m` of the line, as distance_to computes it.
  bool may_come_near(const PlanBox& box, double limit_m) const;
  // Tangent of the angle to the axis; infinite at a right angle.
  double obliqueness() const;
};

// Maximum angle between a line and its axis; a slider placed by eye is within 2 degrees.
inline constexpr double kMaxObliquenessDeg = 3.0;

// The coordinate of a plan vector (x, z) that grows along an axis.
inline int along_index(LineAxis axis) { return axis == LineAxis::kX ? 0 : 1; }

// Least-squares line (orthogonal residuals) through at least two points; the origin is their
// centroid.
PlanLine fit_line(std::span<const Eigen::Vector2d> points, LineAxis axis);

// The same among the lines whose obliqueness is at most `most_oblique`: few stations beside their
// line say little about its direction.
PlanLine fit_line_within(std::span<const Eigen::Vector2d> points, LineAxis axis,
                         double most_oblique);

// The line from which the farthest of the points is the least far, of those that are not more
// oblique than this.
PlanLine narrowest_line(std::span<const Eigen::Vector2d> points, LineAxis axis,
                        double most_oblique);

}  // namespace raywalk
