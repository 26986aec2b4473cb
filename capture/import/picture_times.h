// When pictures were taken, by the camera's own clock.
//
// Source: Exif 2.32 (CIPA DC-008), tags DateTimeOriginal, SubSecTimeOriginal and
// OffsetTimeOriginal, read with libexif; without them, the modification time of the file.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/base/clock.h"

namespace raywalk::capture {

enum class PictureTimeSource {
  kExifUtc,    // Exif, with its offset from UTC
  kExifLocal,  // Exif without it: local time of the camera's clock, taken as UTC
  kFile        // modification time of the file
};

struct PictureTime {
  WallTime time{};
  double resolution_s = 1.0;  // step of the clock; `time` is the lower end of a step
  PictureTimeSource source = PictureTimeSource::kFile;
  std::chrono::minutes utc_offset{0};  // already subtracted from a kExifUtc time
};

// "Exif time", "Exif local time" or "file time", for messages.
std::string name_of(PictureTimeSource source);

// The Exif time of a picture; empty if the file is not a picture, or has no Exif data or no valid
// date in them (cameras write "0000:00:00 00:00:00" if their clock was never set).
std::optional<PictureTime> exif_time(const std::filesystem::path& picture);

// The times of all pictures, from one common source so that they are comparable: Exif with UTC
// offset if every picture has it, else local Exif times if every picture has Exif, else file times
// if none has. Throws Error naming a picture that cannot be read or that has no Exif time while
// others have (it is damaged, or of another camera).
std::vector<PictureTime> picture_times(std::span<const std::filesystem::path> pictures);

}  // namespace raywalk::capture
