// The pictures of a camera's card, as the shots they were taken by.
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
  std::vector<CardFile> files;  // one, or front and back in this order
};

struct CardPictures {
  std::vector<CardShot> shots;  // by time, then by name
  double resolution_s = 1.0;    // of the times, the coarsest of all
  PictureTimeSource source = PictureTimeSource::kFile;
  std::vector<std::filesystem::path> without_partner;  // front pictures without back ones, or back
};

// Sorts out the pictures given. A directory stands for the .jpg, .jpeg and .png files in it and in
// the directories below, other than hidden ones. GoPro's Fusion writes a front and a back file per
// shot, which differ in a part of the name and may lie in folders of their own: GPFR0012.JPG and
// GPBK0012.JPG, GF010012.JPG and GB010012.JPG; where all files are named so they are paired. Throws
// UsageError: no picture given, one given twice; Error where a file cannot be read.
CardPictures read_card(std::span<const std::filesystem::path> files_and_directories);

}  // namespace raywalk::capture
