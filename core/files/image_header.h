// The header of a JPEG or PNG file, read without decoding the image.
//
// JPEG: ITU-T T.81 (the marker structure is annex B). PNG: W3C Portable Network Graphics, second
// edition (chunks: section 5; its eXIf chunk is an extension). Exif 2.32: TIFF 6.0, section 2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace raywalk {

enum class ImageFormat { kJpeg, kPng };

struct ImageHeader {
  ImageFormat format = ImageFormat::kJpeg;
  std::int64_t width = 0;   // pixels, at least 1
  std::int64_t height = 0;  // pixels, at least 1
  int bits_per_channel = 8;
  bool is_grey = false;  // one channel without alpha
  int orientation = 1;   // EXIF's, 1 to 8: how viewers turn the picture; 1 (as stored) if not given
};

// The header of the image that starts with `bytes`; none if they end before the header does. Throws
// Error naming `source`: empty, neither JPEG nor PNG, or an invalid header.
std::optional<ImageHeader> parse_image_header(std::span<const std::byte> bytes,
                                              const std::string& source);

// Whether the image is not truncated: a JPEG has its end-of-image marker, a PNG its IEND chunk.
// Data after that is legal (cameras append previews there). `bytes` start with a header of that
// format.
bool is_complete_image(std::span<const std::byte> bytes, ImageFormat format);

}  // namespace raywalk
