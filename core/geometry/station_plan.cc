#include "core/geometry/station_plan.h"

#include <cmath>

namespace raywalk {

std::vector<Eigen::Vector2d> plans_of(std::span<const StationPose> stations) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(stations.size());
  for (const StationPose& station : stations) points.push_back(plan_of(station));
  return points;
}

Eigen::Vector2d plan_of(const StationPose& station) {
  return {station.position_m.x(), station.position_m.z()};
}

StationTree tree_of(std::span<const StationPose> stations) {
  return StationTree(plans_of(stations));
}

PlanLine line_through(std::span<const StationPose> stations, std::span<const int> members,
                      LineAxis axis) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(members.size());
  for (const int member : members) {
    points.push_back(plan_of(stations[static_cast<size_t>(member)]));
  }
  return fit_line_within(points, axis, std::tan(radians_from_degrees(kMaxObliquenessDeg)));
}

}  // namespace raywalk
