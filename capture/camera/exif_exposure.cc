#include "capture/camera/exif_exposure.h"

#include <cmath>
#include <exiv2/exiv2.hpp>

namespace raywalk::capture {
namespace {

constexpr double kLargestExifIso = 65535.0;  // the tag is a SHORT

// Exiv2 prints warnings about makers' notes to stderr; they are not read here.
void silence_exiv2() { Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute); }

double number_of(const Exiv2::ExifData& exif, const char* key) {
  const auto tag = exif.findKey(Exiv2::ExifKey(key));
  return tag == exif.end() || tag->count() < 1 ? 0.0 : tag->toFloat();
}

}  // namespace

std::optional<ExifExposure> exif_exposure(const std::string& jpeg) {
  silence_exiv2();
  try {
    const auto image =
        Exiv2::ImageFactory::open(reinterpret_cast<const Exiv2::byte*>(jpeg.data()), jpeg.size());
    image->readMetadata();
    const double shutter_s = number_of(image->exifData(), "Exif.Photo.ExposureTime");
    const double iso = number_of(image->exifData(), "Exif.Photo.ISOSpeedRatings");
    if (!std::isfinite(shutter_s) || shutter_s <= 0.0 || !(iso >= 1.0 && iso <= kLargestExifIso)) {
      return std::nullopt;
    }
    return ExifExposure{shutter_s, static_cast<int>(std::lround(iso))};
  } catch (const Exiv2::Error&) {
    return std::nullopt;
  }
}

}  // namespace raywalk::capture
