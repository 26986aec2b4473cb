// Checks a room's content against the checksums stored with it: `raywalk-build-lf verify`.
#pragma once

#include <cstdint>

#include "core/room/room.h"

namespace raywalk::build_lf {

struct VerifiedCounts {
  std::int64_t panoramas = 0;
  std::int64_t distance_maps = 0;
};

// Reads every volume once, in parallel. Throws Error that names line, station and file of the first
// damage found and says how many there are.
VerifiedCounts verify_room(const Room& room);

}  // namespace raywalk::build_lf
