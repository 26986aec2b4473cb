#include "build_lf/require/stored_size.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "build_lf/pack/room_maps.h"
#include "core/base/parallel.h"
#include "core/geometry/spacing.h"
#include "core/room/distance_maps.h"

namespace raywalk::build_lf {
namespace {

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

KeptShare kept_share(const OmegaMap& map, int width, double most_omega_error) {
  const OmegaMap coarse = resized(map, width);
  const double scale = static_cast<double>(width) / map.size().width;
  KeptShare share;
  for (int row = 0; row < map.size().height; ++row) {
    const double phi_rad = angles_from_pixel({0.0, static_cast<double>(row)}, map.size()).phi_rad;
    for (int theta = 0; theta < map.size().width; ++theta) {
      const float omega = map.at(theta, row);
      if (omega < 0.0f) continue;
      const float read = coarse.sample({(theta + 0.5) * scale - 0.5, (row + 0.5) * scale - 0.5});
      const bool kept = read >= 0.0f && std::abs(read - omega) <= most_omega_error;
      share.known += std::cos(phi_rad);
      if (kept) share.kept += std::cos(phi_rad);
    }
  }
  return share;
}

// kept_share over a sample of maps, for each of `widths`.
std::vector<KeptShare> kept_shares(const Room& room, const std::vector<int>& widths,
                                   double most_omega_error) {
  const std::vector<MapStation> maps = all_maps(room);
  const size_t count = std::min<size_t>(kMaxResampledMaps, maps.size());
  std::vector<std::vector<KeptShare>> of_map(count);
  parallel_for(0, static_cast<int>(count), 1, [&](int begin, int end) {
    for (size_t i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const MapStation& index = maps[i * maps.size() / count];
      const OmegaMap map = omega_map_of(room.distances(index.line), index.map);
      for (const int width : widths) of_map[i].push_back(kept_share(map, width, most_omega_error));
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

double useful_width(const StorageNeed& need) {
  const double residual_rad = need.omega_error * std::hypot(need.reach_m, 0.5 * need.spacing_m);
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
  facts.omega_steps =
      layers_for_tolerance(need.scene, need.reach_m, angle_of_pixels(need.tolerance_px, width));
  facts.omega_bits = static_cast<int>(
      std::bit_width(static_cast<std::uint64_t>(facts.omega_steps) + kSpecialCodes - 1));
  const auto needed = static_cast<std::uint64_t>(stations_needed);
  const std::uint64_t code_bytes = (static_cast<std::uint64_t>(facts.omega_bits) + 7) / 8;
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
