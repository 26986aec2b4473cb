// Comparisons of neighbouring frames on a line, by which faulty ones (frame_checks.h) are found.
#pragma once

#include <span>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/quality/colour_comparison.h"
#include "core/geometry/grid.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Two stations of a line, in their order.
struct StationPair {
  StationIndex from;
  StationIndex to;
};

struct StationLink {
  StationPair pair;
  ColourComparison compared{};  // `from` with `to`

  // The change of exposure: the natural logarithm of the factor of the levels, in the channel that
  // changes most.
  double log_exposure_step() const;
};

// Each station with the next two on its line, ordered by station.
std::vector<StationPair> pairs_to_compare(const Grid& grid);

// Compares the pairs, at kComparisonWidth or the room's width if that is smaller. Each thread holds
// only a few reduced panoramas at a time, so memory does not grow with the number of stations,
// except for the result. The result does not depend on the number of threads.
std::vector<StationLink> measure_links(const Room& room, std::span<const StationPair> pairs);

}  // namespace raywalk::build_lf
