#include "core/view/map_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/geometry/fast_math.h"
#include "core/view/map_cache.h"

namespace raywalk {
namespace {

std::vector<MapStation> maps_of_lines(const Room& room, std::span<const int> lines) {
  std::vector<MapStation> maps;
  for (const int line : lines) {
    const auto& stations = room.grid().lines[static_cast<size_t>(line)].stations;
    int map = 0;
    for (const int station : room.distances(line).stations()) {
      maps.push_back({line, map++, station, stations[static_cast<size_t>(station)].position_m});
    }
  }
  return maps;
}

// The nearest to a viewpoint first; equally near ones in the order of the lines.
std::vector<MapStation> maps_by_distance(const Room& room, std::span<const int> lines,
                                         const Eigen::Vector3d& viewpoint_m) {
  std::vector<MapStation> maps = maps_of_lines(room, lines);
  std::ranges::stable_sort(maps, {}, [&](const MapStation& map) {
    return (map.position_m - viewpoint_m).squaredNorm();
  });
  return maps;
}

bool is_near(const MapStation& map, std::span<const MapStation> others, double gap_m) {
  return std::any_of(others.begin(), others.end(), [&](const MapStation& other) {
    return (other.position_m - map.position_m).norm() < gap_m;
  });
}

}  // namespace

std::vector<MapStation> all_maps(const Room& room) {
  std::vector<int> lines(room.grid().lines.size());
  std::iota(lines.begin(), lines.end(), 0);
  return maps_of_lines(room, lines);
}

std::vector<MapStation> nearest_maps(const Room& room, std::span<const int> lines,
                                     const Eigen::Vector3d& viewpoint_m, double gap_m,
                                     int most_per_line, int most) {
  std::vector<MapStation> chosen;
  for (const MapStation& map : maps_by_distance(room, lines, viewpoint_m)) {
    if (static_cast<int>(chosen.size()) == most) break;
    const auto of_line = std::count_if(chosen.begin(), chosen.end(), [&](const MapStation& other) {
      return other.line == map.line;
    });
    if (of_line < most_per_line && !is_near(map, chosen, gap_m)) chosen.push_back(map);
  }
  return chosen;
}

MapSpread map_spread(const Grid& grid, PlanPoint viewpoint) {
  const auto cell = find_cell(grid, viewpoint);
  if (!cell) return {.gap_m = 0.0, .most_per_line = std::numeric_limits<int>::max()};
  const Cell& c = grid.cells[static_cast<size_t>(*cell)];
  const double side_m = std::min(c.x_max_m - c.x_min_m, c.z_max_m - c.z_min_m);
  return {.gap_m = 0.125 * side_m, .most_per_line = 2};
}

std::vector<MapStation> farther_maps(const Room& room, std::span<const MapStation> near,
                                     const Eigen::Vector3d& viewpoint_m, int most) {
  std::vector<int> lines(room.grid().lines.size());
  std::iota(lines.begin(), lines.end(), 0);
  std::vector<MapStation> chosen;
  for (const MapStation& map : maps_by_distance(room, lines, viewpoint_m)) {
    if (static_cast<int>(chosen.size()) == most) break;
    const double gap_m = 0.25 * (map.position_m - viewpoint_m).norm();
    // A map at the viewpoint itself is already among the nearest.
    if (gap_m > 0.0 && !is_near(map, near, gap_m) && !is_near(map, chosen, gap_m)) {
      chosen.push_back(map);
    }
  }
  return chosen;
}

MapLookup look_up(const Room& room, const MapStation& map, const Eigen::Vector3f& direction,
                  float inverse, const Eigen::Vector3d& viewpoint_m, float tolerance) {
  const DistanceVolume& volume = room.distances(map.line);
  const PanoramaSize size = volume.size();
  const Eigen::Vector3f seen = direction + inverse * (viewpoint_m - map.position_m).cast<float>();
  const float plan = std::sqrt(seen.x() * seen.x() + seen.z() * seen.z());
  MapLookup result;
  result.inverse_there = inverse / std::max(1e-30f, std::sqrt(plan * plan + seen.y() * seen.y()));
  const float width = static_cast<float>(size.width);
  const float height = static_cast<float>(size.height);
  const float u = (fast_atan2(seen.x(), seen.z()) / float(kTwoPi) + 0.5f) * width - 0.5f;
  const float v = std::clamp((0.5f - fast_atan2(seen.y(), plan) / float(kPi)) * height - 0.5f, 0.0f,
                             height - 1.0f);
  const int left = static_cast<int>(u + 1.0f) - 1;  // floor: u is at least -1
  const int upper = std::min(static_cast<int>(v), size.height - 2);
  const float right_part = u - static_cast<float>(left);
  const float lower_part = v - static_cast<float>(upper);
  float sum = 0.0f;
  float total = 0.0f;
  float best_part = -1.0f;
  for (int side = 0; side < 2; ++side) {
    const int column = (left + side + size.width) % size.width;
    const auto distance = volume.distance_column(map.map, column);
    const auto confidence = volume.confidence_column(map.map, column);
    for (int below = 0; below < 2; ++below) {
      const auto row = static_cast<size_t>(upper) + static_cast<size_t>(below);
      const float held = stored_inverse(distance[row], confidence[row]);
      if (held < 0.0f) continue;
      result.inverse_around = std::max(result.inverse_around, held);
      const float part = (side == 0 ? 1.0f - right_part : right_part) *
                         (below == 0 ? 1.0f - lower_part : lower_part);
      if (part > best_part) {
        best_part = part;
        result.inverse_map = held;
      }
      if (std::fabs(held - result.inverse_there) <= tolerance * result.inverse_there) {
        sum += part * held;
        total += part;
      }
    }
  }
  if (total > 0.01f) result.inverse_map = sum / total;
  return result;
}

}  // namespace raywalk
