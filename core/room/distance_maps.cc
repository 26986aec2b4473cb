#include "core/room/distance_maps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

bool same_surface(float a, float b, float tolerance) {
  return std::abs(a - b) <= tolerance * std::max(a, b);
}

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
      const double solid_angle =
          std::cos(angles_from_pixel({0.0, static_cast<double>(row)}, size).phi_rad);
      looked_at += solid_angle;
      if (confidence[i] == 0 || !(distances_m[i] > 0.0f)) continue;
      samples->push_back({.distance_m = distances_m[i],
                          .weight = static_cast<float>(solid_angle * confidence[i] / 255.0)});
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

float surface_tolerance_of(int width) {
  static const double slope = std::tan(radians_from_degrees(80.0));
  return static_cast<float>(std::min(0.25, slope * kTwoPi / width));
}

float InverseMap::sample(PixelPosition pixel) const {
  const PixelsAround around = pixels_around(pixel, size_);
  const float nearest = at(around.nearest_column(), around.nearest_row());
  if (nearest < 0.0f) return nearest;
  const float tolerance = surface_tolerance_of(size_.width);
  double sum = 0.0, weight = 0.0;
  for (size_t i = 0; i < 2; ++i) {
    for (size_t j = 0; j < 2; ++j) {
      const float inverse = at(around.column[i], around.row[j]);
      if (inverse < 0.0f || !same_surface(inverse, nearest, tolerance)) continue;
      sum += around.weight(i, j) * inverse;
      weight += around.weight(i, j);
    }
  }
  return static_cast<float>(sum / weight);
}

InverseMap inverse_map_of(const DistanceVolume& volume, int map, std::uint8_t least_confidence) {
  InverseMap result(volume.size());
  for (int theta = 0; theta < volume.size().width; ++theta) {
    const auto distances_m = volume.distance_column(map, theta);
    const auto confidence = volume.confidence_column(map, theta);
    for (int row = 0; row < volume.size().height; ++row) {
      const auto i = static_cast<size_t>(row);
      if (confidence[i] < least_confidence || !(distances_m[i] > 0.0f)) continue;
      const float inverse = 1.0f / distances_m[i];
      if (std::isfinite(inverse)) result.at(theta, row) = inverse;
    }
  }
  return result;
}

InverseMap resized(const InverseMap& map, int width) {
  InverseMap result({width, width / 2});
  const double scale = static_cast<double>(map.size().width) / width;
  for (int theta = 0; theta < width; ++theta) {
    for (int row = 0; row < width / 2; ++row) {
      result.at(theta, row) = map.sample({(theta + 0.5) * scale - 0.5, (row + 0.5) * scale - 0.5});
    }
  }
  return result;
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
