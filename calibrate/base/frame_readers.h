// The two readers of read_capture_set (capture_set.h): of a session, and of a folder with
// poses.csv.
#pragma once

#include <filesystem>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// The frames of a session, from its database as docs/session.md documents it. Lines, stations and
// files; every value is checked (core/session), and that each file is there with its size in bytes,
// but not the pictures. Throws as read_capture_set.
CaptureSet read_session_frames(const CaptureInput& input);

// "<directory>/poses.csv".
std::filesystem::path frame_list_of(const std::filesystem::path& directory);

// The frames of poses.csv, and of gt.csv if there is one: lines, stations, held-out frames and
// files; picture sizes are not checked. Throws as read_capture_set.
CaptureSet read_listed_frames(const CaptureInput& input);

}  // namespace raywalk::calibrate
