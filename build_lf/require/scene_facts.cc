#include "build_lf/require/scene_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "build_lf/pack/room_maps.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/room/distance_maps.h"
#include "core/view/distance_view.h"

namespace raywalk::build_lf {
namespace {

constexpr int kMaxSamples = 2'000'000;  // 32 MB
constexpr int kMaxSamplesPerMap = 16384;
constexpr std::array kShares{0.01, 0.5, 0.99};
// In units of the reach N/2: from close to the line to the diagonal of a cell.
constexpr std::array kReaches{0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 2.8284271247461903};

double sky_share(std::span<const DistanceSample> samples) {
  double sky = 0.0, all = 0.0;
  for (const DistanceSample& sample : samples) {
    all += sample.weight;
    if (std::isinf(sample.distance_m)) sky += sample.weight;
  }
  return sky / all;
}

double inverse(double distance_m) { return 1.0 / distance_m; }  // 0 for the sky

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
      surface_tolerance_of(std::min(size.width, room.distances(to.line).size().width));
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

DistanceFacts distance_facts(const Room& room) {
  int maps = 0;
  for (size_t line = 0; line < room.grid().lines.size(); ++line) {
    maps += room.distances(static_cast<int>(line)).maps();
  }
  const int per_map = std::clamp(kMaxSamples / std::max(1, maps), 256, kMaxSamplesPerMap);
  DistanceSamples known = sample_distances(room, per_map);
  if (known.samples.empty()) {
    throw Error(
        fmt::format("{}: the room has no known distances to measure; run raywalk-build-lf depth "
                    "on it, or pack it with raywalk-build-lf pack --distance DIR",
                    room.directory().string()));
  }
  DistanceFacts facts;
  const std::vector<double> quantiles = distance_quantiles(known.samples, kShares);
  facts.near_m = quantiles[0];
  facts.median_m = quantiles[1];
  facts.far_m = quantiles[2];
  facts.sky_share = sky_share(known.samples);
  facts.known_share = known.known_share;
  facts.omega_error_per_m = omega_error(room);
  return facts;
}

double typical_reach_m(const Grid& grid) {
  double side_m = std::numeric_limits<double>::infinity();
  for (const Cell& cell : grid.cells) {
    side_m = std::min({side_m, cell.x_max_m - cell.x_min_m, cell.z_max_m - cell.z_min_m});
  }
  if (grid.cells.empty()) {
    side_m = 0.0;
    for (const Line& line : grid.lines) side_m = std::max(side_m, line.last_m() - line.first_m());
  }
  return 0.5 * side_m;
}

LayerFacts layer_facts(const DistanceFacts& distance, double reach_m, double tolerance_rad) {
  LayerFacts facts{inverse(distance.far_m), inverse(distance.near_m), {}};
  for (const double reach : kReaches) {
    const double d_p_m = reach * reach_m;
    facts.by_d_p.push_back({d_p_m, layers_for_tolerance(facts.range(), d_p_m, tolerance_rad)});
  }
  return facts;
}

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
