// Measures the requirements of a room's scene: `raywalk-build-lf require`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "build_lf/require/facts.h"
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
SceneFacts measure_requirements(const Room& room, double tolerance_px);

// Measures the room and writes ROOM/require.json; with `thin` also writes the thinned room and adds
// its quality to ROOM/require.json; with `report` writes the report. Every output is written
// atomically. Returns a summary for the terminal. Throws UsageError for a tolerance out of range.
// Throws Error before any work if the room has no distances, if `thin` exists (with replace_thin:
// unless it is a room other than the measured one), equals or contains `report`, or if an output
// cannot be written; and before writing anything if no station that `thin` would keep has a
// distance map.
std::string require_room(const RequireOptions& options);

}  // namespace raywalk::build_lf
