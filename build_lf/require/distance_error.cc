#include "build_lf/require/distance_error.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "build_lf/require/room_maps.h"
#include "core/base/parallel.h"
#include "core/room/omega_map.h"
#include "core/view/distance_view.h"

namespace raywalk::build_lf {
namespace {

constexpr int kMaxComparedMaps = 24;
constexpr int kPixelsPerMap = 16384;

const MapStation& nearest_other(const std::vector<MapStation>& maps, size_t own) {
  size_t nearest = own == 0 ? 1 : 0;
  const auto distance = [&](size_t i) {
    return (maps[i].position_m - maps[own].position_m).norm();
  };
  for (size_t i = 0; i < maps.size(); ++i) {
    if (i != own && distance(i) < distance(nearest)) nearest = i;
  }
  return maps[nearest];
}

struct Difference {
  double omega = 0.0;
  double weight = 0.0;  // solid angle
};

std::vector<Difference> differences(const Room& room, const MapStation& from,
                                    const MapStation& to) {
  const DistanceVolume& own = room.distances(from.line);
  const PanoramaSize size = own.size();
  const double pixels = static_cast<double>(size.width) * size.height;
  const int stride = std::max(1, static_cast<int>(std::lround(std::sqrt(pixels / kPixelsPerMap))));
  const float tolerance =
      std::max(surface_tolerance(size), surface_tolerance(room.distances(to.line).size()));
  std::vector<Difference> found;
  for (int theta = stride / 2; theta < size.width; theta += stride) {
    const auto distance_m = own.distance_column(from.map, theta);
    const auto confidence = own.confidence_column(from.map, theta);
    for (int row = stride / 2; row < size.height; row += stride) {
      const auto i = static_cast<size_t>(row);
      if (confidence[i] < kMinConfidence || !(distance_m[i] > 0.0f)) continue;
      const SphereAngles angles =
          angles_from_pixel({static_cast<double>(theta), static_cast<double>(row)}, size);
      const MapLookup there = look_up(room, to, direction_from_angles(angles).cast<float>(),
                                      1.0f / distance_m[i], from.position_m, tolerance);
      const float difference = std::abs(there.omega_map - there.omega_there);
      if (there.omega_map < 0.0f ||
          difference > tolerance * std::max(there.omega_map, there.omega_there)) {
        continue;
      }
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
  const std::vector<MapStation> maps = all_maps(room);
  if (maps.size() < 2) return std::nullopt;
  const int count = std::min(kMaxComparedMaps, static_cast<int>(maps.size()));
  std::vector<std::vector<Difference>> found(static_cast<size_t>(count));
  parallel_for(0, count, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const size_t own = static_cast<size_t>(i) * maps.size() / static_cast<size_t>(count);
      found[static_cast<size_t>(i)] = differences(room, maps[own], nearest_other(maps, own));
    }
  });
  std::vector<Difference> all;
  for (const auto& each : found) all.insert(all.end(), each.begin(), each.end());
  const std::optional<double> difference = quantile(std::move(all), kTrustedShare);
  if (!difference) return std::nullopt;
  return *difference / std::sqrt(2.0);
}

}  // namespace raywalk::build_lf
