// The pictures on a camera's card, grouped into shots.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "capture/import/picture_times.h"
#include "capture/session/session.h"

namespace raywalk::capture {

struct CardFile {
  std::filesystem::path file;
  FrameLens lens = FrameLens::kBoth;
};

struct CardShot {
  WallTime time{};              // by the camera's clock
  std::vector<CardFile> files;  // one, or front then back
};

struct CardPictures {
  std::vector<CardShot> shots;  // by time, then by name
  double resolution_s = 1.0;    // of the times; the coarsest of all files
  PictureTimeSource source = PictureTimeSource::kFile;
  std::vector<std::filesystem::path> unpaired;  // front without back, or back without front
};

// Groups the given files into shots. A directory is searched recursively for .jpg, .jpeg, .jpe,
// .jfif, .insp and .png files, except hidden ones. GoPro's Fusion writes a front and a back file
// per shot, possibly in separate folders: GPFR0012.JPG and GPBK0012.JPG, or GF010012.JPG and
// GB010012.JPG. Files are paired if all of them follow this naming. Throws UsageError if no picture
// is given or one is given twice, Error if a file cannot be read.
CardPictures read_card(std::span<const std::filesystem::path> files_and_directories);

}  // namespace raywalk::capture
