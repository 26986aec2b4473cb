// The exposure of a picture from its Exif data.
#pragma once

#include <optional>
#include <string>

namespace raywalk::capture {

struct ExifExposure {
  double shutter_s = 0.0;  // more than 0
  int iso = 0;             // more than 0
};

// From the tags ExposureTime and PhotographicSensitivity (Exif 2.32, CIPA DC-008, called
// ISOSpeedRatings before) of a JPEG file; none if one is missing or not positive, or the bytes hold
// no readable Exif data.
std::optional<ExifExposure> exif_exposure(const std::string& jpeg);

}  // namespace raywalk::capture
