// The panoramas and masks of an export.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "build_lf/export/export_options.h"
#include "build_lf/export/exported_stations.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// "front_000.png", or ".jpg".
std::string picture_name(const ExportedStation& station, bool jpeg);
// "images/front_000.png", and "masks/front_000.png"; both relative to the export, with '/'.
std::string panorama_file(const ExportedStation& station, bool jpeg);
std::string mask_file(const ExportedStation& station);

// Writes them into an existing directory; masks only where the room has pixels that are not to be
// used, then of all stations. Throws Error.
void write_panoramas(const Room& room, const std::vector<ExportedStation>& stations,
                     const ExportOptions& options, const std::filesystem::path& directory);

}  // namespace raywalk::build_lf
