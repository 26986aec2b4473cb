// PNG files (W3C PNG, third edition), looked through before libpng decodes them, as it prints what
// it finds wrong.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <string_view>

namespace raywalk {

struct PngHeader {
  int width = 0;  // at least 1
  int height = 0;
  int bits_per_channel = 8;
  bool is_grey = false;    // one channel without alpha
  bool has_alpha = false;  // pixels may be transparent
};

// From the beginning of a file, up to its pixels. Throws Error naming `source` if its first chunk
// is damaged or not there.
PngHeader read_png_header(std::span<const std::byte> bytes, const std::string& source);

// The data of the first chunk of a type ("iCCP") in front of the pixels; empty if there is none.
std::string_view png_chunk(std::span<const std::byte> bytes, std::string_view type);

// The image in a whole file; `flags` are those of cv::imdecode. Throws Error naming `source`:
// damaged as far as its checksums can tell, or cut short.
cv::Mat decode_png(std::span<const std::byte> bytes, int flags, const std::string& source);

}  // namespace raywalk
