// OpenSfM's reconstruction.json of spherical pictures.
//
// opensfm.org/docs/dataset.html, "Reconstruction file format", and opensfm.org/docs/geometry.html:
// `rotation` (an axis times its angle, radians) and `translation` convert world to camera
// coordinates. The camera has x right, y down and looks along z; a spherical picture has u = lon /
// 2 pi with lon = atan2(x, z), so that its middle looks along z. The world is right-handed with z
// up (east, north, up where there was GPS).
#pragma once

#include <filesystem>
#include <string>

#include "calibrate/import/imported_poses.h"

namespace raywalk::calibrate {

// Of several reconstructions the one with the most shots, with a warning. Throws Error naming file
// and place: not JSON, no shots, a camera that is not spherical.
ImportedPoses read_opensfm(const std::filesystem::path& file);
ImportedPoses opensfm_of_text(const std::string& text, const std::filesystem::path& file);

}  // namespace raywalk::calibrate
