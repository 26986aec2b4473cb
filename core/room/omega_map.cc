#include "core/room/omega_map.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

bool same_surface(float a, float b, float tolerance) {
  return std::abs(a - b) <= tolerance * std::max(a, b);
}

}  // namespace

float surface_tolerance_of(int width) {
  static const double slope = std::tan(radians_from_degrees(80.0));
  return static_cast<float>(std::min(0.25, slope * kTwoPi / width));
}

float OmegaMap::sample(PixelPosition pixel) const {
  const PixelsAround around = pixels_around(pixel, size_);
  const float nearest = at(around.nearest_column(), around.nearest_row());
  if (nearest < 0.0f) return nearest;
  const float tolerance = surface_tolerance_of(size_.width);
  double sum = 0.0, weight = 0.0;
  for (size_t i = 0; i < 2; ++i) {
    for (size_t j = 0; j < 2; ++j) {
      const float omega = at(around.column[i], around.row[j]);
      if (omega < 0.0f || !same_surface(omega, nearest, tolerance)) continue;
      sum += around.weight(i, j) * omega;
      weight += around.weight(i, j);
    }
  }
  return static_cast<float>(sum / weight);
}

OmegaMap omega_map_of(const DistanceVolume& volume, int map, std::uint8_t least_confidence) {
  OmegaMap result(volume.size());
  for (int theta = 0; theta < volume.size().width; ++theta) {
    const auto distances_m = volume.distance_column(map, theta);
    const auto confidence = volume.confidence_column(map, theta);
    for (int row = 0; row < volume.size().height; ++row) {
      const auto i = static_cast<size_t>(row);
      if (confidence[i] < least_confidence || !(distances_m[i] > 0.0f)) continue;
      const float omega = 1.0f / distances_m[i];
      if (std::isfinite(omega)) result.at(theta, row) = omega;
    }
  }
  return result;
}

OmegaMap resized(const OmegaMap& map, int width) {
  OmegaMap result({width, width / 2});
  const double scale = static_cast<double>(map.size().width) / width;
  for (int theta = 0; theta < width; ++theta) {
    for (int row = 0; row < width / 2; ++row) {
      result.at(theta, row) = map.sample({(theta + 0.5) * scale - 0.5, (row + 0.5) * scale - 0.5});
    }
  }
  return result;
}

}  // namespace raywalk
