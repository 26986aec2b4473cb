// A room as panoramas with poses, for nerfstudio or any other program.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "build_lf/export/export_room.h"
#include "build_lf/export/exported_stations.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Writes images, masks, transforms.json and, if the room has distances, points.ply into an existing
// directory. Returns what was written, for the user. Throws Error.
std::string write_nerfstudio(const Room& room, const std::vector<ExportedStation>& stations,
                             const ExportOptions& options, const std::filesystem::path& directory);

// Writes images, masks, poses.csv, and of stations with distances distances/NAME.png (16-bit
// millimetres along the ray, 0: no surface or unknown) and confidence/NAME.png (8-bit, 0: unknown).
std::string write_frames(const Room& room, const std::vector<ExportedStation>& stations,
                         const ExportOptions& options, const std::filesystem::path& directory);

}  // namespace raywalk::build_lf
