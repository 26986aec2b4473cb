// Stations in the plan. Internal to find_grid (grid.h).
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/grid.h"
#include "core/geometry/plan_line.h"
#include "core/geometry/station_tree.h"

namespace raywalk {

// The plan position of a station.
Eigen::Vector2d plan_of(const StationPose& station);

// The plan positions of stations, by index.
std::vector<Eigen::Vector2d> plans_of(std::span<const StationPose> stations);
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

// The least-squares line through these stations, no more oblique than kMaxObliquenessDeg.
PlanLine line_through(std::span<const StationPose> stations, std::span<const int> members,
                      LineAxis axis);

}  // namespace raywalk
