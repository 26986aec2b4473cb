#include "core/room/kept_stations.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/geometry/position_tolerance.h"

namespace raywalk {
namespace {

int nearest_station(const Line& line, double along_m) {
  const auto off_m = [&](const Station& station) { return std::abs(station.along_m - along_m); };
  return static_cast<int>(std::ranges::min_element(line.stations, {}, off_m) -
                          line.stations.begin());
}

std::set<int> fixed_stations(const Grid& grid, const Line& line) {
  std::set<int> fixed{0, static_cast<int>(line.stations.size()) - 1};
  for (const Line& other : grid.lines) {
    if (other.axis != line.axis) {
      fixed.insert(nearest_station(line, along_line(line, intersection_of(line, other))));
    }
  }
  return fixed;
}

}  // namespace

std::vector<std::vector<int>> held_out_stations(const Grid& grid, int every) {
  std::vector<std::vector<int>> left_out;
  for (const Line& line : grid.lines) {
    std::vector<int>& of_line = left_out.emplace_back();
    const int last = static_cast<int>(line.stations.size()) - 1;
    for (int station = every / 2; station < last; station += every) of_line.push_back(station);
  }
  return left_out;
}

KeptStations stations_except(const Grid& grid, const std::vector<std::vector<int>>& left_out) {
  KeptStations kept;
  for (std::size_t i = 0; i < grid.lines.size(); ++i) {
    std::vector<int>& of_line = kept.emplace_back();
    for (int station = 0; station < static_cast<int>(grid.lines[i].stations.size()); ++station) {
      if (!std::ranges::binary_search(left_out[i], station)) of_line.push_back(station);
    }
  }
  return kept;
}

std::vector<int> needed_stations(const Grid& grid, int index, double spacing_m,
                                 std::span<const int> preferred) {
  const Line& line = grid.lines[static_cast<size_t>(index)];
  const std::set<int> fixed = fixed_stations(grid, line);
  const int last = static_cast<int>(line.stations.size()) - 1;
  const auto along_m = [&](int i) { return line.stations[static_cast<size_t>(i)].along_m; };
  const double rounding = rounding_m(line);
  std::vector<int> needed{0};
  while (needed.back() != last) {
    const int here = needed.back();
    const int stop = *fixed.upper_bound(here);
    int farthest = here + 1;  // even if the gap to it is already too wide
    int farthest_preferred = -1;
    for (int i = here + 1; i <= stop; ++i) {
      if (i > here + 1 && along_m(i) - along_m(here) > spacing_m + rounding) break;
      farthest = i;
      if (std::ranges::binary_search(preferred, i)) farthest_preferred = i;
    }
    // A fixed station is always kept, and the next step starts from it.
    const bool at_stop = farthest == stop;
    needed.push_back(farthest_preferred >= 0 && !at_stop ? farthest_preferred : farthest);
  }
  return needed;
}

KeptStations needed_stations(const Room& room, double spacing_m, Preferred preferred) {
  KeptStations kept;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const auto mapped = preferred == Preferred::kWithDistances ? room.distances(line).stations()
                                                               : std::span<const int>();
    kept.push_back(needed_stations(room.grid(), line, spacing_m, mapped));
  }
  return kept;
}

std::filesystem::path held_out_directory(const std::filesystem::path& room) {
  return room / "held-out";
}

}  // namespace raywalk
