// Pictures whose EXIF orientation asks viewers to turn or mirror them.
#pragma once

#include <filesystem>

namespace raywalk {

// Collects the pictures of one run for one warning. Raywalk uses pixels as they are stored: those
// of a lens have to stay where its calibration has them, and turning by 90 degrees makes no
// panorama.
class TurnedPictures {
 public:
  // `orientation`: EXIF's, 1 to 8; 1 is upright.
  void add(const std::filesystem::path& file, int orientation);
  // Logs a warning that names the first turned picture, its orientation and how many others are
  // turned; nothing if none is.
  void warn() const;

 private:
  std::filesystem::path first_;
  int first_orientation_ = 1;
  int count_ = 0;
};

}  // namespace raywalk
