#include "build_lf/pack/room_maps.h"

namespace raywalk::build_lf {

std::vector<MapStation> all_maps(const Room& room) {
  std::vector<MapStation> all;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const std::vector<Station>& stations = room.grid().lines[static_cast<size_t>(line)].stations;
    int map = 0;
    for (const int station : room.distances(line).stations()) {
      all.push_back({line, map++, station, stations[static_cast<size_t>(station)].position_m});
    }
  }
  return all;
}

}  // namespace raywalk::build_lf
