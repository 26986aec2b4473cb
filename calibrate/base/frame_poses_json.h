// The "frames" array of a JSON file of poses (frame_poses.h), for files with more keys.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "calibrate/base/frame_poses.h"

namespace raywalk {
class CheckedJson;
}

namespace raywalk::calibrate {

nlohmann::ordered_json frame_poses_json(const CaptureSet& set, const FramePoses& poses);

// Reads them back. Throws Error naming the place of a frame that the set does not have, one that
// occurs twice, and of a value that is missing or of another type.
FramePoses frame_poses_in(const CheckedJson& frames, const CaptureSet& set);

}  // namespace raywalk::calibrate
