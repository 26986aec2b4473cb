// Distance maps in the forms that views use them in, kept from one view to the next: viewpoints of
// a walk share most of their maps.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/parallel.h"
#include "core/room/room.h"
#include "core/view/map_choice.h"
#include "core/view/map_points.h"

namespace raywalk {

// Inverse of a stored distance, 1/m, at most 1e9, because the inverse of a tiny one may overflow a
// float; negative where it is unknown or its confidence is below kMinConfidence.
float stored_inverse(float distance_m, std::uint8_t confidence);

// The inverse distances of a map, as stored_inverse(), [theta][phi].
std::vector<float> inverse_distances(const DistanceVolume& volume, int map);

// A map whose points a view shows.
struct SurfaceMap {
  SurfaceMap(const DistanceVolume& volume, int map);
  std::size_t bytes() const { return (inverse.size() + 3 * points.inverse.size()) * sizeof(float); }

  PanoramaSize size;
  std::vector<float> inverse;
  MapPoints points;
};

// A map that tells what is occluded from its station.
struct OccluderMap {
  OccluderMap(const DistanceVolume& volume, int map);
  std::size_t bytes() const { return nearest.size() * sizeof(float); }

  PanoramaSize size;
  // Of the surfaces in the 2 x 2 pixels at, right of and below each: the nearest one's inverse
  // distance, negative where none is known. [theta][phi].
  std::vector<float> nearest;
};

template <typename Map>
class MapCache {
 public:
  // The room must outlive the object.
  explicit MapCache(const Room& room) : room_(room) {}

  // The maps of `stations`, no two alike; those not kept are read, in parallel. Kept are these and,
  // up to kKeptBytes in all, the ones used last before them.
  std::vector<std::shared_ptr<const Map>> get(std::span<const MapStation> stations) {
    std::vector<Entry> used;
    for (const MapStation& at : stations) {
      const auto known = std::ranges::find_if(entries_, [&](const Entry& entry) {
        return entry.line == at.line && entry.map == at.map;
      });
      if (known == entries_.end()) {
        used.push_back({at.line, at.map, nullptr});
      } else {
        used.push_back(std::move(*known));
        entries_.erase(known);
      }
    }
    parallel_for(0, static_cast<int>(used.size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        Entry& entry = used[static_cast<std::size_t>(i)];
        if (entry.kept) continue;
        entry.kept = std::make_shared<const Map>(room_.distances(entry.line), entry.map);
      }
    });
    std::vector<std::shared_ptr<const Map>> maps;
    std::size_t bytes = 0;
    for (const Entry& entry : used) {
      maps.push_back(entry.kept);
      bytes += entry.kept->bytes();
    }
    for (Entry& before : entries_) {
      bytes += before.kept->bytes();
      if (bytes > kKeptBytes) break;
      used.push_back(std::move(before));
    }
    entries_ = std::move(used);
    return maps;
  }

  static constexpr std::size_t kKeptBytes = std::size_t{128} << 20;

 private:
  struct Entry {
    int line = -1, map = -1;
    std::shared_ptr<const Map> kept;
  };
  const Room& room_;
  std::vector<Entry> entries_;  // used last, first
};

}  // namespace raywalk
