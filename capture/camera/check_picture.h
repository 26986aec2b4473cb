// Checks that the bytes sent by a camera, or copied from its card, are an intact picture.
#pragma once

#include <string>

#include "capture/camera/camera.h"

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

}  // namespace raywalk::capture
