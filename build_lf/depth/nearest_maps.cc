#include "build_lf/depth/nearest_maps.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>

namespace raywalk::build_lf {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double place_of(const Eigen::Vector3d& position_m) {
  return 0.8 * position_m.x() + 0.6 * position_m.z();
}

// The nearest of the maps seen, so many at most, by distance and index.
class Nearest {
 public:
  explicit Nearest(std::size_t most) : most_(most) {}

  void add(double away_m, int map) {
    const std::pair added(away_m, map);
    found_.insert(std::ranges::upper_bound(found_, added), added);
    if (found_.size() > most_) found_.pop_back();
  }
  // Beyond this no map is among them.
  double reach_m() const {
    if (found_.size() < most_) return kInfinity;
    return found_.empty() ? 0.0 : found_.back().first;
  }
  const std::vector<std::pair<double, int>>& found() const { return found_; }

 private:
  std::size_t most_;
  std::vector<std::pair<double, int>> found_;
};

}  // namespace

NearestMaps::NearestMaps(std::vector<MapPlace> maps) : maps_(std::move(maps)) {
  for (const MapPlace& map : maps_) {
    order_.emplace_back(place_of(map.position_m), static_cast<int>(order_.size()));
  }
  std::ranges::sort(order_);
}

std::vector<int> NearestMaps::around(StationIndex station, const Eigen::Vector3d& position_m,
                                     std::size_t own, std::size_t others) const {
  constexpr double kRounding_m = 1e-8;
  const double here = place_of(position_m);
  auto next = std::ranges::lower_bound(order_, std::pair(here, 0));
  auto last = next;
  Nearest of_line(own), of_others(others);
  while (true) {
    const double to_next = next == order_.end() ? kInfinity : next->first - here;
    const double to_last = last == order_.begin() ? kInfinity : here - std::prev(last)->first;
    const double away = std::min(to_next, to_last);
    if (away == kInfinity) break;
    if (away > std::max(of_line.reach_m(), of_others.reach_m()) + kRounding_m) break;
    const int index = to_next <= to_last ? (next++)->second : (--last)->second;
    const MapPlace& map = maps_[static_cast<std::size_t>(index)];
    if (map.station == station) continue;
    (map.station.line == station.line ? of_line : of_others)
        .add((map.position_m - position_m).norm(), index);
  }
  std::vector<std::pair<double, int>> found;
  std::ranges::merge(of_line.found(), of_others.found(), std::back_inserter(found));
  std::vector<int> nearest;
  nearest.reserve(found.size());
  for (const auto& [away_m, index] : found) nearest.push_back(index);
  return nearest;
}

}  // namespace raywalk::build_lf
