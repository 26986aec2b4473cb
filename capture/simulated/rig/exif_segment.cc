#include "capture/simulated/rig/exif_segment.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <exiv2/exiv2.hpp>
#include <string_view>

namespace raywalk::capture {
namespace {

constexpr std::string_view kStartOfImage = "\xFF\xD8";
constexpr std::string_view kExifMarker = "\xFF\xE1";        // APP1
constexpr std::string_view kExifIdentifier("Exif\0\0", 6);  // Exif 2.32, 4.7.2
constexpr std::size_t kLargestSegment = 65535;              // its length has two bytes

// Exposure times as cameras write them: 1/60 s rather than 16667/1000000 s.
Exiv2::URational exposure_time(double shutter_s) {
  if (shutter_s < 0.3) return {1, static_cast<std::uint32_t>(std::lround(1.0 / shutter_s))};
  return {static_cast<std::uint32_t>(std::lround(shutter_s * 10.0)), 10};
}

Exiv2::ExifData tags_of(const PictureExif& exif) {
  using std::chrono::milliseconds;
  const auto since_epoch =
      std::chrono::floor<milliseconds>(exif.taken_at.time_since_epoch()).count();
  const std::time_t seconds = static_cast<std::time_t>(std::floor(since_epoch / 1000.0));
  const auto ms = static_cast<int>(since_epoch - 1000 * static_cast<std::int64_t>(seconds));
  Exiv2::ExifData tags;
  tags["Exif.Image.Make"] = "Raywalk";
  tags["Exif.Image.Model"] = exif.model;
  tags["Exif.Photo.DateTimeOriginal"] = fmt::format("{:%Y:%m:%d %H:%M:%S}", fmt::gmtime(seconds));
  tags["Exif.Photo.SubSecTimeOriginal"] = fmt::format("{:03}", ms);
  tags["Exif.Photo.0x9011"] = std::string("+00:00");  // OffsetTimeOriginal; Exiv2 0.27 has no name
  tags["Exif.Photo.ExposureTime"] = exposure_time(exif.shutter_s);
  tags["Exif.Photo.ISOSpeedRatings"] = static_cast<std::uint16_t>(exif.iso);
  tags["Exif.Photo.ExposureProgram"] = static_cast<std::uint16_t>(exif.automatic ? 2 : 1);
  tags["Exif.Photo.WhiteBalance"] = static_cast<std::uint16_t>(exif.automatic ? 0 : 1);
  return tags;
}

}  // namespace

std::string with_exif(const std::string& jpeg, const PictureExif& exif) {
  if (!jpeg.starts_with(kStartOfImage)) return jpeg;
  Exiv2::Blob tiff;
  Exiv2::ExifData tags = tags_of(exif);
  Exiv2::ExifParser::encode(tiff, Exiv2::bigEndian, tags);
  const std::size_t length = 2 + kExifIdentifier.size() + tiff.size();
  if (length > kLargestSegment) return jpeg;
  std::string out;
  out.reserve(jpeg.size() + length + kExifMarker.size());
  out.append(kStartOfImage).append(kExifMarker);
  out.push_back(static_cast<char>(length >> 8));
  out.push_back(static_cast<char>(length & 0xFF));
  out.append(kExifIdentifier).append(tiff.begin(), tiff.end());
  out.append(jpeg, kStartOfImage.size());
  return out;
}

}  // namespace raywalk::capture
