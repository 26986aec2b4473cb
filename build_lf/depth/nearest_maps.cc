#include "build_lf/depth/nearest_maps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace raywalk::build_lf {
namespace {

Eigen::Vector2d in_plan(const Eigen::Vector3d& position_m) {
  return {position_m.x(), position_m.z()};
}

std::vector<Eigen::Vector2d> points_of(const std::vector<MapPlace>& maps) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(maps.size());
  for (const MapPlace& map : maps) points.push_back(in_plan(map.position_m));
  return points;
}

}  // namespace

NearestMaps::NearestMaps(std::vector<MapPlace> maps)
    : maps_(std::move(maps)), tree_(points_of(maps_)) {
  Eigen::AlignedBox2d extent;
  for (const MapPlace& map : maps_) extent.extend(in_plan(map.position_m));
  if (maps_.empty()) return;
  extent_m_ = extent.diagonal().norm();
  typical_m_ = extent_m_ / std::sqrt(static_cast<double>(maps_.size()));
}

std::vector<int> NearestMaps::around(StationIndex station, const Eigen::Vector3d& position_m,
                                     std::size_t own, std::size_t others) const {
  if (maps_.empty()) return {};
  // From everywhere within this, all maps are in reach.
  const double farthest_m = extent_m_ + (tree_.point(0) - in_plan(position_m)).norm() + 1e-9;
  for (double reach_m = typical_m_; reach_m < farthest_m; reach_m *= 2.0) {
    if (reach_m <= 0.0) break;
    std::vector<int> near = within(reach_m, station, position_m, own, others);
    if (near.size() == own + others) return near;
  }
  return within(farthest_m, station, position_m, own, others);
}

std::vector<int> NearestMaps::within(double reach_m, StationIndex station,
                                     const Eigen::Vector3d& position_m, std::size_t own,
                                     std::size_t others) const {
  const Eigen::Vector2d here = in_plan(position_m);
  const auto may_hold = [&](const PlanBox& box) { return box.least_apart(here).norm() <= reach_m; };
  const bool all = reach_m > extent_m_;
  std::vector<std::pair<double, int>> by_distance;
  tree_.find(may_hold, [&](int i) {
    const MapPlace& map = maps_[static_cast<std::size_t>(i)];
    const double away_m = (map.position_m - position_m).norm();
    // A map beyond the reach may be farther than one that is not visited.
    if (!(map.station == station) && (all || away_m <= reach_m))
      by_distance.emplace_back(away_m, i);
    return false;
  });
  std::ranges::sort(by_distance);
  std::vector<int> nearest;
  for (const auto& [away_m, i] : by_distance) {
    std::size_t& open =
        maps_[static_cast<std::size_t>(i)].station.line == station.line ? own : others;
    if (open == 0) continue;
    --open;
    nearest.push_back(i);
  }
  return nearest;
}

}  // namespace raywalk::build_lf
