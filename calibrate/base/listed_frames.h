// The frames of a folder with poses.csv. A step of read_capture_set (capture_set.h).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// "<directory>/poses.csv".
std::filesystem::path frame_list_of(const std::filesystem::path& directory);

// The names of listed files, in their order: their stems, or where those repeat their paths without
// extension, '/' written '_'. Throws Error naming `list` where two are the same even so.
std::vector<std::string> frame_names(std::span<const std::string> files,
                                     const std::filesystem::path& list);

// Lines, stations and files; sizes of the pictures are not looked at. Throws as read_capture_set.
CaptureSet read_listed_frames(const CaptureInput& input);

}  // namespace raywalk::calibrate
