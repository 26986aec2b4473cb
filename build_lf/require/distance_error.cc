#include "build_lf/require/distance_error.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "build_lf/require/omega_map.h"
#include "core/base/parallel.h"

namespace raywalk::build_lf {
namespace {

constexpr int kMaxComparedMaps = 24;
constexpr int kPixelsPerMap = 16384;

struct MapPlace {
  int line = 0;
  int map = 0;
  Eigen::Vector3d position_m{0, 0, 0};
};

std::vector<MapPlace> all_maps(const Room& room) {
  std::vector<MapPlace> places;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const auto stations = room.distances(line).stations();
    for (int map = 0; map < static_cast<int>(stations.size()); ++map) {
      const auto station = static_cast<size_t>(stations[static_cast<size_t>(map)]);
      places.push_back(
          {line, map, room.grid().lines[static_cast<size_t>(line)].stations[station].position_m});
    }
  }
  return places;
}

const MapPlace& nearest_other(const std::vector<MapPlace>& places, size_t own) {
  size_t nearest = own == 0 ? 1 : 0;
  const auto distance = [&](size_t i) {
    return (places[i].position_m - places[own].position_m).norm();
  };
  for (size_t i = 0; i < places.size(); ++i) {
    if (i != own && distance(i) < distance(nearest)) nearest = i;
  }
  return places[nearest];
}

struct Difference {
  double omega = 0.0;
  double weight = 0.0;  // solid angle
};

std::vector<Difference> differences(const Room& room, const MapPlace& from, const MapPlace& to) {
  const OmegaMap own = omega_map_of(room.distances(from.line), from.map);
  const OmegaMap other = omega_map_of(room.distances(to.line), to.map);
  const PanoramaSize size = own.size();
  const double pixels = static_cast<double>(size.width) * size.height;
  const int stride = std::max(1, static_cast<int>(std::lround(std::sqrt(pixels / kPixelsPerMap))));
  const float tolerance = std::max(own.surface_tolerance(), other.surface_tolerance());
  std::vector<Difference> found;
  for (int theta = stride / 2; theta < size.width; theta += stride) {
    for (int row = stride / 2; row < size.height; row += stride) {
      const float omega = own.at(theta, row);
      if (omega < 0.0f) continue;
      const SphereAngles angles =
          angles_from_pixel({static_cast<double>(theta), static_cast<double>(row)}, size);
      const SeenPoint seen =
          seen_from(direction_from_angles(angles), omega, from.position_m - to.position_m);
      const float there = other.sample(pixel_from_angles(seen.angles, other.size()));
      const float difference = std::abs(there - seen.omega);
      if (there < 0.0f || difference > tolerance * std::max(there, seen.omega)) continue;
      found.push_back({difference, std::cos(angles.phi_rad)});
    }
  }
  return found;
}

std::optional<double> quantile(std::vector<Difference> values, double share) {
  std::ranges::sort(values, {}, &Difference::omega);
  double total = 0.0, passed = 0.0;
  for (const Difference& value : values) total += value.weight;
  for (const Difference& value : values) {
    passed += value.weight;
    if (passed >= share * total) return value.omega;
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> omega_error(const Room& room) {
  const std::vector<MapPlace> places = all_maps(room);
  if (places.size() < 2) return std::nullopt;
  const int count = std::min(kMaxComparedMaps, static_cast<int>(places.size()));
  std::vector<std::vector<Difference>> found(static_cast<size_t>(count));
  parallel_for(0, count, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const size_t own = static_cast<size_t>(i) * places.size() / static_cast<size_t>(count);
      found[static_cast<size_t>(i)] = differences(room, places[own], nearest_other(places, own));
    }
  });
  std::vector<Difference> all;
  for (const auto& each : found) all.insert(all.end(), each.begin(), each.end());
  const std::optional<double> difference = quantile(std::move(all), kTrustedShare);
  if (!difference) return std::nullopt;
  return *difference / std::sqrt(2.0);
}

}  // namespace raywalk::build_lf
