// The frames of a folder with poses.csv, and with gt.csv if there is one. A step of
// read_capture_set (capture_set.h).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// "<directory>/poses.csv", and "<directory>/gt.csv".
std::filesystem::path frame_list_of(const std::filesystem::path& directory);
std::filesystem::path held_out_list_of(const std::filesystem::path& directory);

// Frame names of the listed files, in order: their stems, or, where stems repeat, their paths
// without extension, with '_' for '/'; escaped (core/base/escaped.h). Throws Error naming `list` if
// two names are still the same.
std::vector<std::string> frame_names(std::span<const std::string> files,
                                     const std::filesystem::path& list);

// Lines, stations, held-out frames and files; picture sizes are not checked. Throws as
// read_capture_set.
CaptureSet read_listed_frames(const CaptureInput& input);

}  // namespace raywalk::calibrate
