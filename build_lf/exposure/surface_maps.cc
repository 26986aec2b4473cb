#include "build_lf/exposure/surface_maps.h"

#include <algorithm>
#include <limits>

#include "build_lf/exposure/patch_ratios.h"

namespace raywalk::build_lf {
namespace {

// The part [begin, end) of `count` that the i-th of `parts` covers, at least one.
struct Run {
  int begin = 0;
  int end = 0;
};

Run covered(int i, int parts, int count) {
  const int begin = static_cast<int>(static_cast<std::int64_t>(i) * count / parts);
  const int end = static_cast<int>(static_cast<std::int64_t>(i + 1) * count / parts);
  return {begin, std::max(end, begin + 1)};
}

// The inverse distance of a block of pixels; confidence 0 if it shows several surfaces or a pixel
// is not to be relied on.
void reduce_block(const DistanceVolume& volume, int map, Run theta, Run phi, float* omega,
                  std::uint8_t* confidence) {
  // Inverse distances on one surface differ by at most this share, between neighbouring pixels.
  constexpr float kOneSurface = 0.1F;
  float least = std::numeric_limits<float>::max();
  float most = 0.0F;
  std::uint8_t least_confidence = 255;
  float sum = 0.0F;
  for (int t = theta.begin; t < theta.end; ++t) {
    const auto distances_m = volume.distance_column(map, t);
    const auto confidences = volume.confidence_column(map, t);
    for (auto p = static_cast<size_t>(phi.begin); p < static_cast<size_t>(phi.end); ++p) {
      const float value = 1.0F / distances_m[p];
      least = std::min(least, value);
      most = std::max(most, value);
      sum += value;
      least_confidence = std::min(least_confidence, confidences[p]);
    }
  }
  *omega = sum / static_cast<float>((theta.end - theta.begin) * (phi.end - phi.begin));
  const bool one_surface = most - least <= kOneSurface * most;
  *confidence = one_surface ? least_confidence : std::uint8_t{0};
}

InverseDistanceMap reduced_map(const Room& room, StationIndex station, int map, PanoramaSize size) {
  const DistanceVolume& volume = room.distances(station.line);
  const Line& line = room.grid().lines[static_cast<size_t>(station.line)];
  InverseDistanceMap reduced{
      station, line.stations[static_cast<size_t>(station.station)].position_m, size, {}, {}};
  const auto pixels = static_cast<size_t>(size.width) * static_cast<size_t>(size.height);
  reduced.omega.resize(pixels);
  reduced.confidence.resize(pixels);
  for (int theta = 0; theta < size.width; ++theta) {
    const Run thetas = covered(theta, size.width, volume.size().width);
    for (int phi = 0; phi < size.height; ++phi) {
      const size_t pixel = pixel_index(theta, phi, size);
      reduce_block(volume, map, thetas, covered(phi, size.height, volume.size().height),
                   &reduced.omega[pixel], &reduced.confidence[pixel]);
    }
  }
  return reduced;
}

}  // namespace

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
    const auto stations = room.distances(station.line).stations();
    const auto found = std::lower_bound(stations.begin(), stations.end(), station.station);
    return reduced_map(room, station, static_cast<int>(found - stations.begin()), size);
  };
  return maps;
}

}  // namespace raywalk::build_lf
