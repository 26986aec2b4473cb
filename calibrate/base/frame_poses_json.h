// The "frames" array of a JSON file of poses (frame_poses.h), for files with more keys, which
// read_frame_poses reads too.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

nlohmann::ordered_json frame_poses_json(const CaptureSet& set, const FramePoses& poses);

}  // namespace raywalk::calibrate
