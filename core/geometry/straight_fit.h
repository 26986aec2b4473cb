// Straight lines v(u) through points (u, v). Internal to find_grid (grid.h).
#pragma once

#include <Eigen/Core>
#include <span>

namespace raywalk {

// The line of least squares, v = middle_v + slope (u - middle_u).
struct StraightFit {
  // Of at least one point; level if all have the same u.
  explicit StraightFit(std::span<const Eigen::Vector2d> points);

  // How far a point is above the line, along v.
  double off(const Eigen::Vector2d& point) const {
    return point.y() - middle_v - slope * (point.x() - middle_u);
  }
  // The standard error of the line at `u`, by the scatter of the points about it; 0 for fewer than
  // three points.
  double error_at(double u) const;

  double middle_u = 0.0, middle_v = 0.0, slope = 0.0;

 private:
  double count_, scatter_u_ = 0.0, variance_ = 0.0;
};

// A line is known to within this many of its standard errors.
inline constexpr double kSureErrors = 2.0;

// The points (u, v) with |v - middle - slope u| <= half_width.
struct Strip {
  double slope = 0.0;
  double middle = 0.0;
  double half_width = 0.0;
};

// The strip of the least half width, measured along v, that holds all points (at least one), among
// those whose slope is between -steepest and steepest.
Strip narrowest_strip(std::span<const Eigen::Vector2d> points, double steepest);

}  // namespace raywalk
