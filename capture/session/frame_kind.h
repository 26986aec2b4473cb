// Whether pictures are of the kind that the configuration says, before hours are spent on them.
#pragma once

#include <string>

#include "capture/camera/camera_config.h"

namespace raywalk::capture {

// Looks at the pixels (core/panorama/picture_look.h) of a picture file, `bytes`, called `name` in
// messages. Throws Error where they clearly show another kind of frame than `configured`. Logs a
// warning where its metadata state that the camera was not upright.
void require_frame_kind(const std::string& bytes, FrameKind configured, const std::string& name);

}  // namespace raywalk::capture
