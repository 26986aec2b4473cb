// What a room's scene requires: `raywalk-build-lf require`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

struct RequireOptions {
  std::filesystem::path room{};
  double tolerance_px = 0.5;                      // at the panorama's width, 0.01..100
  std::optional<std::filesystem::path> thin{};    // room to make of the stations needed
  std::optional<std::filesystem::path> report{};  // directory of index.html and require.json
};

// Measures the room. Takes memory for a few maps per thread, whatever the room's size. Throws Error
// where the room has no distances.
RoomRequirements measure_requirements(const Room& room, double tolerance_px);

// Measures and writes ROOM/require.json; thins if asked and writes it again with what that lost;
// writes the report. Each is complete when it appears. Returns what to tell the user. Throws
// UsageError for a tolerance out of range; Error before any work where the room has no distances,
// where `thin` exists (as the report's directory, too) and where an output cannot be written, and
// before anything is written where no station that `thin` would keep has a distance map.
std::string require_room(const RequireOptions& options);

}  // namespace raywalk::build_lf
