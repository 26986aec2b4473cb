#include "core/files/turned_pictures.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <string>

namespace raywalk {
namespace {

// What viewers do with orientations 1 to 8 (Exif 2.32, tag 0x0112).
constexpr std::array kMeanings = {"show it as stored",
                                  "mirror it",
                                  "turn it by 180 degrees",
                                  "mirror it and turn it by 180 degrees",
                                  "mirror it and turn it by 270 degrees",
                                  "turn it by 90 degrees",
                                  "mirror it and turn it by 90 degrees",
                                  "turn it by 270 degrees"};

}  // namespace

void TurnedPictures::add(const std::filesystem::path& file, int orientation) {
  if (orientation == 1) return;
  if (count_++ > 0) return;
  first_ = file;
  first_orientation_ = orientation;
}

void TurnedPictures::warn() const {
  if (count_ == 0) return;
  const std::string others = count_ == 1 ? "" : fmt::format(", as in {} more pictures", count_ - 1);
  spdlog::warn(
      "{}: its EXIF orientation {} (viewers {}) is ignored{}: pixels are used as they are stored; "
      "if only viewers show the pictures upright, turn their pixels first, for example with "
      "exiftran -ai",
      first_.string(), first_orientation_,
      kMeanings[static_cast<std::size_t>(first_orientation_ - 1)], others);
}

}  // namespace raywalk
