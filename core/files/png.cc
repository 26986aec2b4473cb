#include "core/files/png.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "core/files/jpeg.h"

namespace raywalk {
namespace {

using PngBytes = std::span<const std::byte>;

constexpr std::size_t kSignatureBytes = 8;
// A chunk has its length, 4 bytes; type, 4; data; and the checksum of type and data, 4 (5.3).
constexpr std::size_t kChunkLength = 4, kChunkType = 4, kChunkChecksum = 4;

std::string_view chars_of(PngBytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Numbers of PNG.
std::uint32_t big_endian(std::string_view text, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<std::uint8_t>(text[i]);
  return value;
}

void require_whole_chunks(std::string_view text, const std::string& source) {
  std::string_view type;
  for (std::size_t at = kSignatureBytes; type != "IEND";) {
    const std::size_t left = text.size() - at;
    const std::size_t rest =
        left < kChunkLength ? 0 : big_endian(text, at) + kChunkType + kChunkChecksum;
    if (rest == 0 || left - kChunkLength < rest) throw_damaged_image(source, "its end is missing");
    const std::string_view chunk = text.substr(at + kChunkLength, rest - kChunkChecksum);
    const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(chunk.data()), chunk.size());
    if (sum != big_endian(text, at + kChunkLength + chunk.size())) {
      throw_damaged_image(source, "a checksum is wrong");
    }
    type = chunk.substr(0, kChunkType);
    at += kChunkLength + rest;
  }
}

}  // namespace

// The first chunk, IHDR (5.3 and 11.2.1): length, 4 bytes; type, 4; width, 4; height, 4; bit depth,
// 1; colour type, 1: 0 = grey, 4 = grey with alpha, 6 = colour with alpha; the others may have a
// transparent colour, or palette entries with alpha, in a chunk tRNS (11.3.1.1).
PngHeader read_png_header(PngBytes bytes, const std::string& source) {
  const std::string_view text = chars_of(bytes);
  constexpr std::size_t kType = 12, kWidth = 16, kHeight = 20, kDepth = 24, kColour = 25;
  if (text.size() <= kColour || text.substr(kType, 4) != "IHDR") {
    throw_damaged_image(source, "no PNG header");
  }
  const std::uint32_t width = big_endian(text, kWidth), height = big_endian(text, kHeight);
  if (std::min(width, height) < 1 || std::max(width, height) > std::numeric_limits<int>::max()) {
    throw_damaged_image(source, fmt::format("{}x{} pixels", width, height));
  }
  const char colour = text[kColour];
  return {.width = static_cast<int>(width),
          .height = static_cast<int>(height),
          .bits_per_channel = text[kDepth],
          .is_grey = colour == 0,
          .has_alpha = colour == 4 || colour == 6 || !png_chunk(bytes, "tRNS").empty()};
}

std::string_view png_chunk(PngBytes bytes, std::string_view type) {
  const std::string_view text = chars_of(bytes);
  for (std::size_t at = kSignatureBytes; text.size() > at + kChunkLength + kChunkType;) {
    const std::size_t length = big_endian(text, at);
    const std::string_view found = text.substr(at + kChunkLength, kChunkType);
    at += kChunkLength + kChunkType;
    if (found == "IDAT" || text.size() - at < length) break;
    if (found == type) return text.substr(at, length);
    at += length + kChunkChecksum;
  }
  return {};
}

cv::Mat decode_png(PngBytes bytes, int flags, const std::string& source) {
  require_whole_chunks(chars_of(bytes), source);
  try {
    // OpenCV does not write to it.
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                          const_cast<std::byte*>(bytes.data()));
    cv::Mat image = cv::imdecode(encoded, flags);
    if (!image.empty()) return image;
  } catch (const cv::Exception& e) {
    throw_damaged_image(source, e.err);
  }
  throw_damaged_image(source, "its pixels cannot be decoded");
}

}  // namespace raywalk
