// The panoramas on disk that imported poses are of.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "calibrate/import/imported_poses.h"

namespace raywalk::calibrate {

// The file of each frame: in `folder`, or else where the source says; under the name that the
// source gives it or, without its folders, its last part; with its extension or, if there is no
// such file, another one of pictures. Warns of panoramas in the folder that have no pose. Throws
// UsageError if the folder is unknown; Error naming the frame for one without a file, and as
// panorama_size_of does.
std::vector<std::filesystem::path> find_panoramas(
    const ImportedPoses& poses, const std::optional<std::filesystem::path>& folder);

}  // namespace raywalk::calibrate
