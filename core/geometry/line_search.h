// Finds the straight lines along x and z that a set of captured positions lies on. A step of
// find_grid (grid.h); nothing else needs it.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
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
  // Distance of a point from the line, not signed.
  double distance_to(const Eigen::Vector2d& point) const;
  // The slope against the axis, as the tangent of the angle; infinite at a right angle.
  double obliqueness() const;
};

// A line and the stations (indices) that belong to it.
struct StationGroup {
  PlanLine line;
  std::vector<int> stations;
};

// Lines up to this angle off their axis are accepted: a slider placed by eye comes within 2
// degrees.
inline constexpr double kMaxObliquenessDeg = 3.0;

// The plan position of a station.
Eigen::Vector2d plan_of(const StationPose& station);

// "front_000.jpg (poses.csv:2)", for errors.
std::string name_of(const StationPose& station);

// Least-squares line (orthogonal residuals) through at least two points; the origin is their
// centroid.
PlanLine fit_line(std::span<const Eigen::Vector2d> points, LineAxis axis);

// Median over the stations of the distance to the nearest station of another position.
double median_nearest_distance(std::span<const StationPose> stations);

// Every station goes to exactly one line; where lines cross, a station may be given to either.
// Throws Error when a station fits no line or lies where every line through it has a station
// already.
std::vector<StationGroup> find_lines(std::span<const StationPose> stations, double tolerance_m);

}  // namespace raywalk
