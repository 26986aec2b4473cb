// The frames of a capture session, read from its database as docs/session.md documents it. A step
// of read_capture_set (capture_set.h).
#pragma once

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// Lines, stations and files; every value is checked (core/session), and that each file is there
// with its size in bytes, but not the pictures. Throws as read_capture_set.
CaptureSet read_session_frames(const CaptureInput& input);

}  // namespace raywalk::calibrate
