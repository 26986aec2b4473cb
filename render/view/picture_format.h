// The format of rendered pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace raywalk::render {

struct PictureFormat {
  std::string extension = ".png";  // with the dot, in lower case
  std::optional<int> quality{};    // of JPEG and WebP, 1 to 100; none: 95
};

// The format of a file by its name: .png, .jpg, .jpeg, .webp, .tif or .tiff, in any case. Throws
// UsageError for another name, and for a quality of PNG or TIFF.
PictureFormat picture_format(const std::filesystem::path& file, std::optional<int> quality = {});

}  // namespace raywalk::render
