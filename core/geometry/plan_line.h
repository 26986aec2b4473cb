// Straight lines of the plan and their fit.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <span>

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

}  // namespace raywalk
