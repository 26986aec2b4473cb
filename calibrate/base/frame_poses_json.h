// The "frames" of a JSON file of poses (frame_poses.h), for files that hold more than them;
// read_frame_poses reads those files too.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

nlohmann::ordered_json frame_poses_json(const CaptureSet& set, const FramePoses& poses);

}  // namespace raywalk::calibrate
