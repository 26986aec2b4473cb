#include "build_lf/exposure/surface_maps.h"

#include <algorithm>

#include "build_lf/exposure/patch_ratios.h"
#include "core/room/distance_maps.h"

namespace raywalk::build_lf {

SurfaceMaps surface_maps_of(const Room& room) {
  SurfaceMaps maps;
  int width = std::min(kSurfaceWidth, room.panorama().width);
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const DistanceVolume& volume = room.distances(line);
    if (volume.maps() == 0) continue;
    width = std::min(width, volume.size().width);
    for (const int station : volume.stations()) maps.stations.push_back({line, station});
  }
  maps.size = {width, width / 2};
  maps.read = [&room, size = maps.size](StationIndex station) {
    const DistanceVolume& volume = room.distances(station.line);
    const auto found = std::ranges::lower_bound(volume.stations(), station.station);
    const InverseMap known = resized(
        inverse_map_of(volume, static_cast<int>(found - volume.stations().begin()), kMinConfidence),
        size.width);
    InverseDistanceMap map{station, room.grid().station(station).position_m, size, {}, {}};
    map.inverse.reserve(known.values().size());
    map.confidence.reserve(known.values().size());
    for (const float inverse : known.values()) {
      map.inverse.push_back(std::max(0.0F, inverse));
      map.confidence.push_back(inverse < 0.0F ? 0 : 255);
    }
    return map;
  };
  return maps;
}

}  // namespace raywalk::build_lf
