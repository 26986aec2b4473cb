// Colour comparisons between pairs of stations, from which gains (station_gains.h) and faulty
// frames (frame_checks.h) are determined.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "build_lf/depth/station_pairs.h"
#include "core/panorama/colour_comparison.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Panoramas are compared at this width (or the room's, if that is smaller).
inline constexpr int kLinkWidth = kComparisonWidth;

// The comparison of two stations; values as in ColourComparison, of 8-bit levels.
struct StationLink {
  StationPair pair;
  bool comparable = false;
  std::array<double, 3> log_ratio{};  // `to` over `from`
  std::array<double, 3> log_ratio_error{};
  double change = 0.0;
  double unexplained_change = 0.0;
};

// Compares the pairs. Each thread holds only a few reduced panoramas at a time, so memory does not
// grow with the number of stations, except for the result. The result does not depend on the number
// of threads.
std::vector<StationLink> measure_links(const Room& room, std::span<const StationPair> pairs);

}  // namespace raywalk::build_lf
