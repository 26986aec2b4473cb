// The header of a JPEG or PNG file, read without decoding the image.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "core/geometry/sphere.h"

namespace raywalk {

enum class ImageFormat { kJpeg, kPng };

struct ImageHeader {
  ImageFormat format = ImageFormat::kJpeg;
  PanoramaSize size{};  // pixels, at least 1 x 1; any aspect ratio
  int bits_per_channel = 8;
  bool is_grey = false;  // one channel without alpha
  int orientation = 1;   // EXIF's, 1 to 8: how viewers turn the image; 1 (as stored) if not given
};

// The header of the image that starts with `bytes`, which may be cut off behind it. Throws Error
// naming `source`: empty, neither JPEG nor PNG, a header that is damaged or not all there.
ImageHeader parse_image_header(std::span<const std::byte> bytes, const std::string& source);

// "SOURCE: the image is damaged or cut short (REASON); capture or copy it again".
[[noreturn]] void throw_damaged_image(const std::string& source, const std::string& reason);

}  // namespace raywalk
