// The pictures on a camera's card, grouped into shots, and when they were taken by the camera's
// clock.
//
// Source of the times: Exif 2.32 (CIPA DC-008), tags DateTimeOriginal, SubSecTimeOriginal and
// OffsetTimeOriginal; of pictures without them, the modification time of the file.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {

struct CardFile {
  std::filesystem::path file{};
  WallTime time{};  // the lower end of a step of the clock
  FrameLens lens = FrameLens::kBoth;
};

// The files of a shot: one, or front then back.
using CardShot = std::vector<CardFile>;

struct CardPictures {
  std::vector<CardShot> shots;  // by time, then by name
  // One for all, so that the times are comparable: "Exif time" in UTC if every file has its offset
  // from UTC, else "Exif local time" of the camera's clock, taken as UTC; "file time" if none has
  // Exif.
  std::string time_source;
  double resolution_s = 1.0;                    // step of the clock; the coarsest of all files
  std::vector<std::filesystem::path> unpaired;  // front without back, or back without front
};

// Groups the given files into shots. A directory is searched recursively for .jpg, .jpeg, .jpe,
// .jfif, .insp and .png files, except hidden ones. GoPro's Fusion writes a front and a back file
// per shot, possibly in separate folders: GPFR0012.JPG and GPBK0012.JPG, or GF010012.JPG and
// GB010012.JPG. Files are paired if all of them follow this naming. Throws UsageError if no picture
// is given or one is given twice; Error naming a file that cannot be read, or that has no Exif time
// while others have (it is damaged, or of another camera).
CardPictures read_card(std::span<const std::filesystem::path> files_and_directories);

}  // namespace raywalk::capture
