#include "build_lf/require/scene_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/room/distance_maps.h"
#include "core/view/distance_view.h"
#include "core/view/map_choice.h"

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
  double inverse = 0.0;
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
      const float difference = std::abs(there.inverse_map - there.inverse_there);
      if (there.inverse_map < 0.0f ||
          difference > tolerance * std::max(there.inverse_map, there.inverse_there)) {
        continue;
      }
      found.push_back({difference, std::cos(angles.phi_rad)});
    }
  }
  return found;
}

std::optional<double> quantile(std::vector<Difference> values, double share) {
  std::ranges::sort(values, {}, &Difference::inverse);
  double total = 0.0, passed = 0.0;
  for (const Difference& value : values) total += value.weight;
  for (const Difference& value : values) {
    passed += value.weight;
    if (passed >= share * total) return value.inverse;
  }
  return std::nullopt;
}

constexpr int kMaxResampledMaps = 12;
constexpr int kSmallestWidth = 32;
constexpr std::uint64_t kColourBytes = 3;
constexpr std::uint64_t kConfidenceBytes = 1;
constexpr std::uint64_t kFloatBytes = 4;
constexpr std::uint64_t kSpecialCodes = 2;  // "unknown" and "no surface"

std::uint64_t pixels_of(double width) { return static_cast<std::uint64_t>(width * width / 2.0); }

// Solid angle of a map's known pixels, and of those that a coarser map keeps within the tolerance.
struct KeptShare {
  double known = 0.0;
  double kept = 0.0;
};

KeptShare kept_share(const InverseMap& map, int width, double most_inverse_error) {
  const InverseMap coarse = resized(map, width);
  const double scale = static_cast<double>(width) / map.size().width;
  KeptShare share;
  for (int row = 0; row < map.size().height; ++row) {
    const double phi_rad = angles_from_pixel({0.0, static_cast<double>(row)}, map.size()).phi_rad;
    for (int theta = 0; theta < map.size().width; ++theta) {
      const float inverse = map.at(theta, row);
      if (inverse < 0.0f) continue;
      const float read = coarse.sample({(theta + 0.5) * scale - 0.5, (row + 0.5) * scale - 0.5});
      const bool kept = read >= 0.0f && std::abs(read - inverse) <= most_inverse_error;
      share.known += std::cos(phi_rad);
      if (kept) share.kept += std::cos(phi_rad);
    }
  }
  return share;
}

// kept_share over a sample of maps, for each of `widths`.
std::vector<KeptShare> kept_shares(const Room& room, const std::vector<int>& widths,
                                   double most_inverse_error) {
  const std::vector<MapStation> maps = all_maps(room);
  const size_t count = std::min<size_t>(kMaxResampledMaps, maps.size());
  std::vector<std::vector<KeptShare>> of_map(count);
  parallel_for(0, static_cast<int>(count), 1, [&](int begin, int end) {
    for (size_t i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const MapStation& index = maps[i * maps.size() / count];
      const InverseMap map = inverse_map_of(room.distances(index.line), index.map);
      for (const int width : widths)
        of_map[i].push_back(kept_share(map, width, most_inverse_error));
    }
  });
  std::vector<KeptShare> sum(widths.size());
  for (const std::vector<KeptShare>& shares : of_map) {
    for (size_t i = 0; i < widths.size(); ++i) {
      sum[i].known += shares[i].known;
      sum[i].kept += shares[i].kept;
    }
  }
  return sum;
}

int largest_map_width(const Room& room) {
  int width = 0;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    width = std::max(width, room.distances(line).size().width);
  }
  return width;
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
  facts.inverse_error_per_m = inverse_error(room);
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

std::optional<double> inverse_error(const Room& room) {
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

double useful_width(const StorageNeed& need) {
  const double residual_rad = need.inverse_error * std::hypot(need.reach_m, 0.5 * need.spacing_m);
  return residual_rad > 0.0 ? need.tolerance_px * kTwoPi / residual_rad
                            : std::numeric_limits<double>::infinity();
}

DistanceWidth distance_width_needed(const Room& room, const StorageNeed& need) {
  const double tolerance_rad = angle_of_pixels(need.tolerance_px, room.panorama().width);
  const int own_width = largest_map_width(room);
  std::vector<int> widths;
  for (int width = own_width / 2; width >= kSmallestWidth && width % 2 == 0; width /= 2) {
    widths.push_back(width);
  }
  const std::vector<KeptShare> shares = kept_shares(room, widths, tolerance_rad / need.reach_m);
  DistanceWidth needed{own_width, 1.0};
  for (size_t i = 0; i < widths.size(); ++i) {
    const double share = shares[i].known > 0.0 ? shares[i].kept / shares[i].known : 1.0;
    if (share < kKeptShare) break;
    needed = {widths[i], share};
  }
  return needed;
}

StorageFacts storage_facts(const Room& room, const StorageNeed& need, int stations_needed) {
  const int width = room.panorama().width;
  StorageFacts facts{.reach_m = need.reach_m,
                     .panorama_width_px = width,
                     .worth_width_px = useful_width(need),
                     .distance_width_px = largest_map_width(room)};
  const DistanceWidth distances = distance_width_needed(room, need);
  facts.needed_distance_width_px = distances.width_px;
  facts.share_within_tolerance = distances.share_within_tolerance;
  facts.inverse_steps =
      layers_for_tolerance(need.scene, need.reach_m, angle_of_pixels(need.tolerance_px, width));
  facts.inverse_bits = static_cast<int>(
      std::bit_width(static_cast<std::uint64_t>(facts.inverse_steps) + kSpecialCodes - 1));
  const auto needed = static_cast<std::uint64_t>(stations_needed);
  const std::uint64_t code_bytes = (static_cast<std::uint64_t>(facts.inverse_bits) + 7) / 8;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const auto stations = static_cast<std::uint64_t>(room.volume(line).stations());
    const auto maps = static_cast<std::uint64_t>(room.distances(line).maps());
    facts.ray_bytes += stations * pixels_of(width) * kColourBytes;
    facts.distance_bytes +=
        maps * pixels_of(room.distances(line).size().width) * (kFloatBytes + kConfidenceBytes);
    facts.distance_bytes_needed +=
        maps * pixels_of(distances.width_px) * (code_bytes + kConfidenceBytes);
  }
  facts.ray_bytes_thinned = needed * pixels_of(width) * kColourBytes;
  facts.ray_bytes_worth =
      needed * pixels_of(std::min<double>(width, facts.worth_width_px)) * kColourBytes;
  return facts;
}

}  // namespace raywalk::build_lf
