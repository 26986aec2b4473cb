// The format of rendered pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace raywalk::render {

struct PictureFormat {
  std::string extension = ".png";  // with the dot, in lower case
  int bits = 8;                    // per channel: 8 or 16
  std::optional<int> quality{};    // of JPEG and WebP, 1 to 100; none: 95

  bool operator==(const PictureFormat&) const = default;
};

// What was asked for on the command line.
struct PictureFlags {
  std::optional<int> bits{};     // 8 or 16; none: 16 for TIFF, else 8
  std::optional<int> quality{};  // 1 to 100
};

// The format of a file by its name: .png, .jpg, .jpeg, .webp, .tif or .tiff, in any case. Throws
// UsageError for another name, for a quality of PNG or TIFF, and for 16 bits of JPEG or WebP.
PictureFormat picture_format(const std::filesystem::path& file, const PictureFlags& flags);

}  // namespace raywalk::render
