// What pairs of stations show of one another: how their colours differ, and how far what they see
// does. Exposures (station_gains.h) and faulty frames (frame_checks.h) are told from these.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "build_lf/depth/station_pairs.h"
#include "core/room/room.h"

namespace raywalk {

// Every comparison is made on panoramas reduced to this width (or the room's, if that is smaller):
// colours and gross changes need no more, and noise averages out.
inline constexpr int kLinkWidth = 256;

struct StationLink {
  StationPair pair;
  // Whether enough of both panoramas is neither clipped nor black to compare them. The values below
  // are 0 where it is not.
  bool comparable = false;
  // Natural logarithm of the level in `to` over that in `from`, 8-bit levels of the same surface;
  // red, green, blue.
  std::array<double, 3> log_ratio{};
  std::array<double, 3> log_ratio_error{};  // estimated standard error
  // Root mean square difference of the levels, once `to` is scaled to the colours of `from`: at the
  // same pixel, and of the same surface, where the motion between the two has been followed. The
  // first grows with the baseline; the second only with what motion does not explain.
  double change = 0.0;
  double unexplained_change = 0.0;
};

// Compares them. Reads a few reduced panoramas at a time on each thread, so memory does not grow
// with the number of stations but for the result. The result does not depend on the number of
// threads.
std::vector<StationLink> measure_links(const Room& room, std::span<const StationPair> pairs);

}  // namespace raywalk
