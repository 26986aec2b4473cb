// Makes a frame list for raywalk-build-lf of panoramas whose poses another program found.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "calibrate/import/grid_axes.h"

namespace raywalk::calibrate {

struct ImportOptions {
  std::filesystem::path source{};                    // read_imported_poses
  std::optional<std::filesystem::path> panoramas{};  // folder of the panoramas
  std::optional<std::filesystem::path> faces{};      // read_face_table
  std::optional<std::filesystem::path> reference{};  // frame list of known positions of frames
  AxesOptions axes{};
  std::filesystem::path out{};  // directory; created if missing
  bool replace = false;         // an earlier import in `out` is replaced
};

// Writes OUT/poses.csv, which lists the panoramas where they are, with position and attitude, and
// OUT/import.json, the similarity that was applied. Returns a summary of lines, cells and spacing
// and the next command. Panoramas without a pose are warned of. Throws UsageError where the scale
// is unknown or the panoramas' folder is, Error as read_imported_poses and fit_grid_axes do, for a
// panorama that is missing or no equirectangular picture, and if `out` has a poses.csv already.
std::string import_poses(const ImportOptions& options);

}  // namespace raywalk::calibrate
