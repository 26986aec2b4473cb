// Whether what a camera sent is a picture.
#pragma once

#include <string>

#include "capture/camera/camera.h"

namespace raywalk::capture {

struct CheckedPicture {
  std::string extension;  // "jpg" or "png"
  PanoramaSize size{};
};

// What a whole JPEG or PNG file is. Throws DeviceFault kBadPicture naming
// `source`: empty, a web page, another format, cut short, or not of the size `expected` (0 x 0
// accepts any).
CheckedPicture check_picture(const std::string& bytes, PanoramaSize expected,
                             const std::string& source);

}  // namespace raywalk::capture
