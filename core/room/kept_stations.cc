#include "core/room/kept_stations.h"

#include <algorithm>

namespace raywalk {

KeptStations every_nth_station(const Room& room, int stride) {
  KeptStations kept;
  for (int i = 0; i < static_cast<int>(room.grid().lines.size()); ++i) {
    const auto mapped = room.distances(i).stations();
    const int count = room.volume(i).stations();
    const int step = std::min(stride, count);
    std::vector<int> line;
    for (int begin = 0; begin < count; begin += step) {
      const auto map = std::ranges::lower_bound(mapped, begin);
      const bool has_map = map != mapped.end() && *map < begin + step;
      line.push_back(has_map ? *map : begin);
    }
    if (line.front() != 0) line.insert(line.begin(), 0);
    if (line.back() != count - 1) line.push_back(count - 1);
    kept.push_back(std::move(line));
  }
  return kept;
}

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

std::filesystem::path held_out_directory(const std::filesystem::path& room) {
  return room / "held-out";
}

}  // namespace raywalk
