#include "render/web/station_distances.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "core/view/map_choice.h"
#include "core/view/view_options.h"

namespace raywalk::render {
namespace {

InverseMap map_at_width(InverseMap map, int width) {
  return map.size().width == width ? std::move(map) : resized(map, width);
}

InverseMap map_of(const DistanceView& view) {
  InverseMap map(view.size());
  for (int theta = 0; theta < map.size().width; ++theta) {
    const float* const inverse = view.column(theta);
    for (int row = 0; row < map.size().height; ++row) map.at(theta, row) = inverse[row];
  }
  return map;
}

// A station's own map; none where it has none.
std::optional<InverseMap> own_map(const DistanceVolume& volume, int station) {
  const auto stations = volume.stations();
  const auto found = std::ranges::lower_bound(stations, station);
  if (found == stations.end() || *found != station) return std::nullopt;
  return inverse_map_of(volume, static_cast<int>(found - stations.begin()), kMinConfidence);
}

std::vector<MapStation> maps_around(const Room& room, const Eigen::Vector3d& position_m) {
  std::vector<int> lines(room.grid().lines.size());
  std::iota(lines.begin(), lines.end(), 0);
  const MapSpread spread = map_spread(room.grid(), {position_m.x(), position_m.z()});
  return nearest_maps(room, lines, position_m, spread.gap_m, spread.most_per_line,
                      ViewOptions().distance_maps);
}

}  // namespace

InverseMap StationDistances::seen_from(int line, int station) {
  const Eigen::Vector3d& position_m = room_.grid()
                                          .lines[static_cast<std::size_t>(line)]
                                          .stations[static_cast<std::size_t>(station)]
                                          .position_m;
  const std::vector<MapStation> maps = maps_around(room_, position_m);
  if (maps.empty()) {
    InverseMap far({width_, width_ / 2});
    for (int theta = 0; theta < width_; ++theta) {
      for (int row = 0; row < width_ / 2; ++row) far.at(theta, row) = 0.0F;
    }
    return far;
  }
  view_.compute(maps, position_m);
  InverseMap seen = map_at_width(map_of(view_), width_);
  std::optional<InverseMap> own = own_map(room_.distances(line), station);
  if (!own) return seen;
  const InverseMap known = map_at_width(*std::move(own), width_);
  const double scale = static_cast<double>(view_.size().width) / width_;
  for (int theta = 0; theta < width_; ++theta) {
    const float* const trust = view_.trust(static_cast<int>((theta + 0.5) * scale));
    for (int row = 0; row < width_ / 2; ++row) {
      const bool doubted = trust != nullptr && trust[static_cast<int>((row + 0.5) * scale)] < 1.0F;
      if (known.at(theta, row) >= 0.0F && !doubted) seen.at(theta, row) = known.at(theta, row);
    }
  }
  return seen;
}

}  // namespace raywalk::render
