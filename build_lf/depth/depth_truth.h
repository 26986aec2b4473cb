// Comparison of estimated distances with those packed with the room ("given" distances).
#pragma once

#include <filesystem>
#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/partial_maps.h"
#include "core/room/distance_volume.h"

namespace raywalk::build_lf {

// The given distances of a room, by line; a line without any has an empty volume. Read from where
// they are: in use, or kept beside estimated ones. Throws Error if they are damaged or not as
// recorded.
class GivenDistances {
 public:
  explicit GivenDistances(const Room& room);
  bool empty() const;
  // Inverse distances of a station, 1/m, [theta][phi] at `size`, by nearest-pixel sampling. None if
  // the station has no given map.
  std::optional<std::vector<float>> inverse_of(StationIndex station, PanoramaSize size) const;

 private:
  std::vector<DistanceVolume> volumes_;
};

// Compares every finished map with the given map of its station, if any. Throws Error if no station
// has both.
TruthComparison compare_with_truth(const GivenDistances& given, const DepthPlan& plan,
                                   const PartialMaps& partial);

}  // namespace raywalk::build_lf
