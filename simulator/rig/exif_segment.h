// Exif data of the simulated camera's pictures.
#pragma once

#include <string>

#include "capture/base/clock.h"

namespace raywalk::capture {

struct PictureExif {
  std::string model;
  WallTime taken_at{};     // by the camera's clock, written as UTC with milliseconds
  double shutter_s = 0.0;  // more than 0
  int iso = 0;             // 1 to 65535
  bool automatic = false;  // exposure program and white balance
};

// Inserts an Exif segment (Exif 2.32, CIPA DC-008) into a JPEG file. Data that are not a JPEG file
// are returned unchanged.
std::string with_exif(const std::string& jpeg, const PictureExif& exif);

}  // namespace raywalk::capture
