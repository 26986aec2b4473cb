// A room as a COLMAP model of flat faces, with its pictures.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "build_lf/export/export_room.h"
#include "build_lf/export/exported_stations.h"
#include "core/reconstruction/colmap_model.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The model: a camera and an image for each face of kCubeFaces, one rig, a frame for each station,
// and points from the distances, observed within half a pixel.
ColmapModel colmap_model_of(const Room& room, const std::vector<ExportedStation>& stations,
                            const ExportOptions& options, int face_px);

// Writes images/FACE/NAME, masks/FACE/NAME.png where pixels are not to be used, sparse/0,
// rig_config.json and faces.csv into an existing directory. Returns what was written,
// for the user. Throws Error.
std::string write_colmap(const Room& room, const std::vector<ExportedStation>& stations,
                         const ExportOptions& options, const std::filesystem::path& directory);

}  // namespace raywalk::build_lf
