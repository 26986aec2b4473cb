// The frames of a capture session, read from its database as docs/session.md documents it. A step
// of read_capture_set (capture_set.h).
#pragma once

#include <filesystem>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// "<directory>/session.db".
std::filesystem::path session_database_of(const std::filesystem::path& directory);

// Lines, stations and files; picture sizes are not checked. Throws as read_capture_set.
CaptureSet read_session_frames(const CaptureInput& input);

}  // namespace raywalk::calibrate
