// What a room's scene requires, as far as other commands follow it: measured and stored in
// ROOM/require.json by `raywalk-build-lf require` (docs/file-formats.md), read for `--preset fast`
// and by export-web.
#pragma once

#include <filesystem>
#include <optional>

#include "core/geometry/spacing.h"
#include "core/room/room.h"

namespace raywalk {

inline constexpr const char* kRequirementsFormat = "raywalk-require";
inline constexpr int kRequirementsVersion = 1;

struct RoomRequirements {
  double inverse_max_per_m = 0.0;  // inverse distance of the nearest surfaces
  double spacing_m = 0.0;          // that suffices with distances
  double worth_width_px = 0.0;     // of panoramas; infinite: any
  int distance_width_px = 0;       // that suffices
};

std::filesystem::path requirements_path(const std::filesystem::path& room);

// The requirements stored in the room. None if there are none or, with a warning, if they were
// measured on different distances. Throws Error, saying how to measure again, if the file is
// damaged or of a newer version.
std::optional<RoomRequirements> current_requirements(const Room& room);

}  // namespace raywalk
