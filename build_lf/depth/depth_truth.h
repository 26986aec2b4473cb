// Estimated distances against those that were packed with the room.
#pragma once

#include <filesystem>
#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/partial_maps.h"
#include "core/room/distance_volume.h"

namespace raywalk::build_lf {

// Where estimated distances have replaced given ones, these are kept: `<room>/distances-given`.
inline constexpr const char* kGivenDistances = "distances-given";

// The given distances of a room, by line; empty volumes where a line has none. They are those in
// `<room>/distances` if these were given, else those in `<room>/distances-given`.
class GivenDistances {
 public:
  explicit GivenDistances(const Room& room);
  // The room's `distances` are given ones and have to be kept.
  bool in_use() const { return in_use_; }
  bool empty() const;
  // Inverse distances of a station at a map's size: those of the given map's nearest pixels. None
  // where the station has no map.
  std::optional<std::vector<float>> omega_of(StationIndex station, PanoramaSize size) const;

 private:
  std::vector<DistanceVolume> volumes_;
  bool in_use_ = false;
};

// Compares every finished map whose station has a given one. Throws Error if there is none.
TruthComparison compare_with_truth(const GivenDistances& given, const DepthPlan& plan,
                                   const PartialMaps& partial);

}  // namespace raywalk::build_lf
