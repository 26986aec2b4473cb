#include "core/view/map_cache.h"

#include "core/view/vector_clones.h"

namespace raywalk {
namespace {

// The largest of a row and the one below it, in a column and the one beside it.
RAYWALK_VECTOR_CLONES void find_nearest(const float* here, const float* beside, std::size_t rows,
                                        float* nearest) {
  const auto larger = [](float a, float b) { return a > b ? a : b; };
  for (std::size_t row = 0; row + 1 < rows; ++row) {
    nearest[row] = larger(larger(here[row], here[row + 1]), larger(beside[row], beside[row + 1]));
  }
  nearest[rows - 1] = larger(here[rows - 1], beside[rows - 1]);
}

}  // namespace

float stored_inverse(float distance_m, std::uint8_t confidence) {
  constexpr float kLargest = 1e9f;
  constexpr float kUnknown = -1.0f;
  const float inverse = std::min(1.0f / distance_m, kLargest);
  // Branchless, so that the compiler vectorises it.
  const bool known = (confidence >= kMinConfidence) & (distance_m > 0.0f);
  return known ? inverse : kUnknown;
}

std::vector<float> inverse_distances(const DistanceVolume& volume, int map) {
  const auto rows = static_cast<std::size_t>(volume.size().height);
  std::vector<float> inverse(static_cast<std::size_t>(volume.size().width) * rows);
  for (int theta = 0; theta < volume.size().width; ++theta) {
    const auto distance_m = volume.distance_column(map, theta);
    const auto confidence = volume.confidence_column(map, theta);
    float* const column = inverse.data() + static_cast<std::size_t>(theta) * rows;
    for (std::size_t row = 0; row < rows; ++row) {
      column[row] = stored_inverse(distance_m[row], confidence[row]);
    }
  }
  return inverse;
}

SurfaceMap::SurfaceMap(const DistanceVolume& volume, int map)
    : size(volume.size()), inverse(inverse_distances(volume, map)), points(inverse, size) {}

OccluderMap::OccluderMap(const DistanceVolume& volume, int map) : size(volume.size()) {
  const std::vector<float> inverse = inverse_distances(volume, map);
  nearest.resize(inverse.size());
  const auto rows = static_cast<std::size_t>(size.height);
  for (int theta = 0; theta < size.width; ++theta) {
    const auto at = static_cast<std::size_t>(theta) * rows;
    const std::size_t beside = theta + 1 == size.width ? 0 : at + rows;
    find_nearest(inverse.data() + at, inverse.data() + beside, rows, nearest.data() + at);
  }
}

}  // namespace raywalk
