// What a picture's own Exif data say of its exposure.
#pragma once

#include <optional>
#include <string>

namespace raywalk::capture {

struct ExifExposure {
  double shutter_s = 0.0;  // more than 0
  int iso = 0;             // more than 0
};

// From the tags ExposureTime and PhotographicSensitivity (Exif 2.32, CIPA DC-008, called
// ISOSpeedRatings before) of a JPEG file; none where one is missing, not positive, or the bytes
// hold no readable Exif data. Not for several threads at once: Exiv2 sets itself up at its first
// use.
std::optional<ExifExposure> exif_exposure(const std::string& jpeg);

}  // namespace raywalk::capture
