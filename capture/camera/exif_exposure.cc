#include "capture/camera/exif_exposure.h"

#include <cmath>

#include "core/files/exif.h"

namespace raywalk::capture {

std::optional<ExifExposure> exif_exposure(const std::string& jpeg) {
  constexpr double kLargestIso = 65535.0;  // the tag is a SHORT
  const ExifTags tags(std::as_bytes(std::span(jpeg)));
  const double shutter_s = tags.number(EXIF_TAG_EXPOSURE_TIME).value_or(0.0);
  const double iso = tags.number(EXIF_TAG_ISO_SPEED_RATINGS).value_or(0.0);
  if (shutter_s <= 0.0 || iso < 1.0 || iso > kLargestIso) return std::nullopt;
  return ExifExposure{shutter_s, static_cast<int>(std::lround(iso))};
}

}  // namespace raywalk::capture
