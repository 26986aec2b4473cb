// Verifies a room's content against its stored checksums: `raywalk-build-lf verify`.
#pragma once

#include <cstdint>

#include "core/room/room.h"

namespace raywalk::build_lf {

struct VerifiedCounts {
  std::int64_t panoramas = 0;
  std::int64_t distance_maps = 0;
};

// Reads every volume once, in parallel. Throws Error naming line, station and file of the first
// mismatch and the number of mismatches.
VerifiedCounts verify_room(const Room& room);

}  // namespace raywalk::build_lf
