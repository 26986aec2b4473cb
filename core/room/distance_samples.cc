#include "core/room/distance_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raywalk {
namespace {

// Adds a map's samples; returns the solid angle sampled.
double add_samples(const DistanceVolume& volume, int map, int count,
                   std::vector<DistanceSample>* samples) {
  const PanoramaSize size = volume.size();
  const double pixels = static_cast<double>(size.width) * size.height;
  const int stride = std::max(1, static_cast<int>(std::lround(std::sqrt(pixels / count))));
  double looked_at = 0.0;
  for (int theta = stride / 2; theta < size.width; theta += stride) {
    const auto distances_m = volume.distance_column(map, theta);
    const auto confidence = volume.confidence_column(map, theta);
    for (int row = stride / 2; row < size.height; row += stride) {
      const auto i = static_cast<size_t>(row);
      const SphereAngles angles =
          angles_from_pixel({static_cast<double>(theta), static_cast<double>(row)}, size);
      const double solid_angle = std::cos(angles.phi_rad);
      looked_at += solid_angle;
      if (confidence[i] == 0 || !(distances_m[i] > 0.0f)) continue;
      samples->push_back({.distance_m = distances_m[i],
                          .weight = static_cast<float>(solid_angle * confidence[i] / 255.0),
                          .theta_rad = static_cast<float>(angles.theta_rad),
                          .phi_rad = static_cast<float>(angles.phi_rad)});
    }
  }
  return looked_at;
}

double total_weight(std::span<const DistanceSample> samples) {
  double total = 0.0;
  for (const DistanceSample& sample : samples) total += sample.weight;
  return total;
}

}  // namespace

std::size_t map_count(const Room& room) {
  std::size_t count = 0;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    count += static_cast<std::size_t>(room.distances(line).maps());
  }
  return count;
}

DistanceSamples sample_distances(const Room& room, int per_map) {
  DistanceSamples result;
  double looked_at = 0.0;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const DistanceVolume& volume = room.distances(line);
    for (int map = 0; map < volume.maps(); ++map) {
      looked_at += add_samples(volume, map, per_map, &result.samples);
    }
  }
  if (looked_at > 0.0) result.known_share = std::min(1.0, total_weight(result.samples) / looked_at);
  return result;
}

std::vector<double> distance_quantiles(std::span<DistanceSample> samples,
                                       std::span<const double> shares) {
  std::ranges::sort(samples, {}, &DistanceSample::distance_m);
  const double total = total_weight(samples);
  std::vector<double> quantiles_m;
  for (const double share : shares) {
    double passed = 0.0;
    double quantile_m = std::numeric_limits<double>::quiet_NaN();
    for (const DistanceSample& sample : samples) {
      passed += sample.weight;
      quantile_m = sample.distance_m;
      if (passed >= total * share) break;
    }
    quantiles_m.push_back(quantile_m);
  }
  return quantiles_m;
}

}  // namespace raywalk
