// Which pairs of stations are compared to tell exposures and faulty frames.
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

// The pairs worth comparing: each station with the next and the one after it on its line; of lines
// that cross near stations of both, the nearest stations; and the nearest stations of lines that
// nothing else connects. Ordered: those of a line first, by station.
std::vector<StationPair> pairs_to_compare(const Grid& grid);

}  // namespace raywalk::build_lf
