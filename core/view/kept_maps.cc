#include "core/view/kept_maps.h"

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"

namespace raywalk {
namespace {

std::shared_ptr<const KeptMap> read_map(const DistanceVolume& volume, int map) {
  auto kept = std::make_shared<KeptMap>();
  kept->size = volume.size();
  const auto rows = static_cast<std::size_t>(kept->size.height);
  kept->omega.resize(static_cast<std::size_t>(kept->size.width) * rows);
  for (int theta = 0; theta < kept->size.width; ++theta) {
    const auto distance_m = volume.distance_column(map, theta);
    const auto confidence = volume.confidence_column(map, theta);
    float* const omega = kept->omega.data() + static_cast<std::size_t>(theta) * rows;
    for (std::size_t row = 0; row < rows; ++row) {
      omega[row] = stored_omega(distance_m[row], confidence[row]);
    }
  }
  kept->trust.compute(volume, map);
  return kept;
}

std::size_t bytes_of(const KeptMap& map) { return map.omega.size() * sizeof(float); }

}  // namespace

float stored_omega(float distance_m, std::uint8_t confidence) {
  constexpr float kLargest = 1e9f;
  constexpr float kUnknown = -1.0f;
  const float omega = std::min(1.0f / distance_m, kLargest);
  // Branchless, so that the compiler vectorises it.
  const bool known = (confidence >= kMinConfidence) & (distance_m > 0.0f);
  return known ? omega : kUnknown;
}

std::vector<std::shared_ptr<const KeptMap>> KeptMaps::get(std::span<const Place> places) {
  std::vector<Entry> used;
  for (const Place& place : places) {
    const auto known = std::ranges::find(entries_, place, &Entry::place);
    if (known == entries_.end()) {
      used.push_back({place, nullptr});
    } else {
      used.push_back(std::move(*known));
      entries_.erase(known);
    }
  }
  parallel_for(0, static_cast<int>(used.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      Entry& entry = used[static_cast<std::size_t>(i)];
      if (!entry.map) entry.map = read_map(room_.distances(entry.place.line), entry.place.map);
    }
  });
  std::vector<std::shared_ptr<const KeptMap>> maps;
  std::size_t bytes = 0;
  for (const Entry& entry : used) {
    maps.push_back(entry.map);
    bytes += bytes_of(*entry.map);
  }
  for (Entry& before : entries_) {
    bytes += bytes_of(*before.map);
    if (bytes > kKeptBytes) break;
    used.push_back(std::move(before));
  }
  entries_ = std::move(used);
  return maps;
}

}  // namespace raywalk
