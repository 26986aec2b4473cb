// Checks that the bytes sent by a camera, or copied from its card, are an intact picture of the
// kind that the configuration says, before hours are spent on them.
#pragma once

#include <string>

#include "capture/camera/camera.h"
#include "capture/camera/camera_config.h"
#include "core/geometry/sphere.h"

namespace raywalk::capture {

struct CheckedPicture {
  std::string extension;  // "jpg" or "png"
  PanoramaSize size{};
};

// Format and size of an intact JPEG or PNG file. Throws DeviceFault kBadPicture, naming `source`,
// if it is empty, a web page, of another format, cut short, damaged, or not of the size `expected`
// (0 x 0: any).
CheckedPicture check_picture(const std::string& bytes, PanoramaSize expected,
                             const std::string& source);

// Looks at the pixels (core/panorama/picture_look.h) of a picture file, `bytes`, called `name` in
// messages. Throws Error where they clearly show another kind of frame than `configured`. Logs a
// warning where its metadata state that the camera was not upright.
void require_frame_kind(const std::string& bytes, FrameKind configured, const std::string& name);

}  // namespace raywalk::capture
