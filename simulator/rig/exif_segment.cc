#include "simulator/rig/exif_segment.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>

#include "core/files/exif.h"

namespace raywalk::capture {
namespace {

// Exposure times as cameras write them: 1/60 s rather than 16667/1000000 s.
TiffEntry exposure_time(double shutter_s) {
  if (shutter_s < 0.3) {
    return rational_entry(EXIF_TAG_EXPOSURE_TIME, 1,
                          static_cast<std::uint32_t>(std::lround(1.0 / shutter_s)));
  }
  return rational_entry(EXIF_TAG_EXPOSURE_TIME,
                        static_cast<std::uint32_t>(std::lround(shutter_s * 10.0)), 10);
}

}  // namespace

std::string with_exif(const std::string& jpeg, const PictureExif& exif) {
  if (!jpeg.starts_with("\xFF\xD8")) return jpeg;
  using std::chrono::milliseconds;
  const auto since_epoch =
      std::chrono::floor<milliseconds>(exif.taken_at.time_since_epoch()).count();
  const std::time_t seconds = static_cast<std::time_t>(std::floor(since_epoch / 1000.0));
  const auto ms = static_cast<int>(since_epoch - 1000 * static_cast<std::int64_t>(seconds));
  const std::string date = fmt::format("{:%Y:%m:%d %H:%M:%S}", fmt::gmtime(seconds));
  const std::string block = exif_block(
      {ascii_entry(EXIF_TAG_MAKE, "Raywalk"), ascii_entry(EXIF_TAG_MODEL, exif.model)},
      {ascii_entry(EXIF_TAG_DATE_TIME_ORIGINAL, date),
       ascii_entry(EXIF_TAG_SUB_SEC_TIME_ORIGINAL, fmt::format("{:03}", ms)),
       ascii_entry(EXIF_TAG_OFFSET_TIME_ORIGINAL, "+00:00"), exposure_time(exif.shutter_s),
       short_entry(EXIF_TAG_ISO_SPEED_RATINGS, static_cast<std::uint16_t>(exif.iso)),
       short_entry(EXIF_TAG_EXPOSURE_PROGRAM, exif.automatic ? 2 : 1),
       short_entry(EXIF_TAG_WHITE_BALANCE, exif.automatic ? 0 : 1)});
  return with_app1(jpeg, kExifIdentifier, block);
}

}  // namespace raywalk::capture
