// Selects the pairs of stations to compare for exposure gains and frame checks.
#pragma once

#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/geometry/grid.h"

namespace raywalk::build_lf {

// Two stations that are compared.
struct StationPair {
  StationIndex from;
  StationIndex to;
  friend bool operator==(const StationPair&, const StationPair&) = default;
};

// The pairs to compare: each station with the next two on its line; at a crossing with stations of
// both lines nearby, the nearest stations; and the nearest stations of lines not connected
// otherwise. Pairs within lines come first, ordered by station.
std::vector<StationPair> pairs_to_compare(const Grid& grid);

}  // namespace raywalk::build_lf
