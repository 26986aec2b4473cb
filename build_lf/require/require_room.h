// Measures the requirements of a room's scene: `raywalk-build-lf require`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/block.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

struct RequireOptions {
  std::filesystem::path room{};
  double tolerance_px = 0.5;                      // at the panorama's width, 0.01..100
  std::optional<std::filesystem::path> thin{};    // room to write with the needed stations only
  bool replace_thin = false;                      // a room at `thin` is replaced
  std::optional<std::filesystem::path> report{};  // directory for index.html and require.json
};

// Measures the room. Uses memory for a few maps per thread, independent of the room's size. Throws
// Error if the room has no distances.
RoomRequirements measure_requirements(const Room& room, double tolerance_px);

// Measures the room and writes ROOM/require.json; with `thin` also writes the thinned room and adds
// its quality to ROOM/require.json; with `report` writes the report. Every output is written
// atomically. Returns a summary for the terminal. Throws UsageError for a tolerance out of range.
// Throws Error before any work if the room has no distances, if `thin` exists (with replace_thin:
// unless it is a room other than the measured one), equals or contains `report`, or if an output
// cannot be written; and before writing anything if no station that `thin` would keep has a
// distance map.
std::string require_room(const RequireOptions& options);

// Measures a block of what takes time: the distances of some maps, and some of the stations that
// are re-created. Kept in ROOM/require.partial until they are merged; what is done is not done
// again. Returns a sentence for the terminal.
std::string require_block(const RequireOptions& options, Block block);

// The same as require_room() from the blocks, which are removed then. Throws Error naming the
// blocks that are missing.
std::string merge_requirements(const RequireOptions& options);

}  // namespace raywalk::build_lf
