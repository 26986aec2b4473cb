// The stations with maps that are nearest to a station.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

#include "core/geometry/grid.h"

namespace raywalk::build_lf {

// The `own` nearest of `maps`, each with a `station` and its `position_m`, on the line of
// `station`, and the `others` nearest on all other lines, fewer where there are not so many;
// without that of the station itself. As indices, by increasing distance from `position_m`, equal
// distances by index.
template <typename Maps>
std::vector<int> nearest_maps(const Maps& maps, StationIndex station,
                              const Eigen::Vector3d& position_m, std::size_t own,
                              std::size_t others) {
  using Found = std::vector<std::pair<double, int>>;  // distance and index, in order
  const auto add = [](std::pair<double, int> added, std::size_t most, Found* found) {
    if (found->size() == most && (most == 0 || found->back() < added)) return;
    found->insert(std::ranges::upper_bound(*found, added), added);
    if (found->size() > most) found->pop_back();
  };
  Found of_line, of_others, all;
  for (int i = 0; const auto& map : maps) {
    const std::pair found((map.position_m - position_m).norm(), i++);
    if (map.station == station) continue;
    if (map.station.line == station.line) {
      add(found, own, &of_line);
    } else {
      add(found, others, &of_others);
    }
  }
  std::ranges::merge(of_line, of_others, std::back_inserter(all));
  std::vector<int> nearest;
  nearest.reserve(all.size());
  for (const auto& [away_m, index] : all) nearest.push_back(index);
  return nearest;
}

}  // namespace raywalk::build_lf
