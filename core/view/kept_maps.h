// Distance maps as views gather from them, kept from one view to the next: viewpoints of a walk
// share most of their maps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/room/room.h"
#include "core/view/smooth_distances.h"

namespace raywalk {

// Inverse of a stored distance, 1/m, at most 1e9, because the inverse of a tiny one may overflow a
// float; negative where it is unknown or its confidence is below kMinConfidence.
float stored_omega(float distance_m, std::uint8_t confidence);

struct KeptMap {
  PanoramaSize size;
  std::vector<float> omega;  // as stored_omega(), [theta][phi]
  MapTrust trust;
};

class KeptMaps {
 public:
  // Which map: of a line, by its index into the line's DistanceVolume.
  struct Place {
    int line = -1;
    int map = -1;
    bool operator==(const Place&) const = default;
  };

  // The room must outlive the object.
  explicit KeptMaps(const Room& room) : room_(room) {}

  // The maps at `places`, no two alike; those not kept are read, in parallel. Kept are these and,
  // up to kKeptBytes in all, the ones used last before them.
  std::vector<std::shared_ptr<const KeptMap>> get(std::span<const Place> places);

  static constexpr std::size_t kKeptBytes = std::size_t{64} << 20;

 private:
  struct Entry {
    Place place;
    std::shared_ptr<const KeptMap> map;
  };
  const Room& room_;
  std::vector<Entry> entries_;  // used last, first
};

}  // namespace raywalk
