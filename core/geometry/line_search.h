// Finds the straight lines along x and z through a set of captured positions. Internal to find_grid
// (grid.h).
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

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

// A line and the stations (indices) that belong to it.
struct StationGroup {
  PlanLine line;
  std::vector<int> stations;
};

// Maximum angle between a line and its axis; a slider placed by eye is within 2 degrees.
inline constexpr double kMaxObliquenessDeg = 3.0;

// The plan position of a station.
Eigen::Vector2d plan_of(const StationPose& station);

// The plan positions of stations, by index.
StationTree tree_of(std::span<const StationPose> stations);

// The stations that `accept(index)` takes and that lie within `limit_m` of a line, in ascending
// order.
template <typename Accept>
std::vector<int> stations_near(const StationTree& tree, const PlanLine& line, double limit_m,
                               const Accept& accept) {
  return tree.find([&](const PlanBox& box) { return line.may_come_near(box, limit_m); },
                   [&](int station) {
                     return accept(station) && line.distance_to(tree.point(station)) <= limit_m;
                   });
}

// "front_000.jpg (poses.csv:2)", for errors.
std::string name_of(const StationPose& station);

// Throws Error if a station that is on no line has the position of another, within the tolerance.
void require_own_position(std::span<const StationPose> stations, const StationTree& tree,
                          int station, double tolerance_m);

// Least-squares line (orthogonal residuals) through at least two points; the origin is their
// centroid.
PlanLine fit_line(std::span<const Eigen::Vector2d> points, LineAxis axis);

// Median over the stations of the distance to the nearest station at a different position.
double median_nearest_distance(std::span<const StationPose> stations);

// Assigns every station to exactly one line; at a crossing it may be either. Throws Error when a
// station fits no line, or every line through it already has a station there.
std::vector<StationGroup> find_lines(std::span<const StationPose> stations, double tolerance_m);

}  // namespace raywalk
