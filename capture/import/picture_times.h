// When the pictures of a camera's card were taken, by the camera's own clock.
//
// Source: Exif 2.32 (CIPA DC-008), tags DateTimeOriginal, SubSecTimeOriginal and
// OffsetTimeOriginal, read with Exiv2; where they are not there, the time the file was last
// written.
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
  kExifLocal,  // Exif without one: what the camera's clock showed, as though it were UTC
  kFile        // when the file was written
};

struct PictureTime {
  WallTime time{};
  double resolution_s = 1.0;  // the clock's steps; the time is the lower end of one
  PictureTimeSource source = PictureTimeSource::kFile;
  std::chrono::minutes utc_offset{0};  // already taken off a kExifUtc time
};

// "Exif time", "Exif local time", "file time", for people.
std::string name_of(PictureTimeSource source);

// What the Exif data of a picture say; none where there are none, they hold no valid date (cameras
// write "0000:00:00 00:00:00" where their clock was never set), or the file is no picture.
std::optional<PictureTime> exif_time(const std::filesystem::path& picture);

// The times of pictures that are to be compared with each other, hence all of one source: Exif with
// UTC where every picture has it, local Exif times where every picture has Exif, file times where
// none has. Throws Error naming a picture that has no Exif time where others have (it is damaged,
// or not of the same camera) or cannot be read.
std::vector<PictureTime> picture_times(std::span<const std::filesystem::path> pictures);

}  // namespace raywalk::capture
