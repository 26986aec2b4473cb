// The frames of a folder with poses.csv, and with gt.csv if there is one. A step of
// read_capture_set (capture_set.h).
#pragma once

#include <filesystem>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// "<directory>/poses.csv".
std::filesystem::path frame_list_of(const std::filesystem::path& directory);

// Lines, stations, held-out frames and files; picture sizes are not checked. Throws as
// read_capture_set.
CaptureSet read_listed_frames(const CaptureInput& input);

}  // namespace raywalk::calibrate
