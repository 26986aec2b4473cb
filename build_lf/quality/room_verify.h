// Verifies a room's content against its stored checksums: `raywalk-build-lf verify`.
#pragma once

#include <cstdint>
#include <string>

#include "core/room/room.h"

namespace raywalk::build_lf {

struct VerifiedCounts {
  std::int64_t panoramas = 0;
  std::int64_t distance_maps = 0;  // in use
  std::string kept_distances{};    // origin of those not in use that were verified; empty: none
};

// Reads every volume, in parallel, and the distances that are not in use as well. Throws Error
// naming line, station and file of the first mismatch and the number of mismatches, a file that is
// missing or of another room, or a volume of distances that belongs to no line.
VerifiedCounts verify_room(const Room& room);

// One line: "room.lf: 244 panoramas and ... match their checksums".
std::string text_of(const VerifiedCounts& counts, const Room& room);

}  // namespace raywalk::build_lf
