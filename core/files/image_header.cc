#include "core/files/image_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string_view>

#include "core/base/error.h"
#include "core/files/exif.h"
#include "core/files/jpeg.h"

namespace raywalk {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::string_view kJpegSignature = "\xFF\xD8\xFF";
constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1A\n";

std::string_view text_of(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// A file that ends within its signature is cut short, not of another format.
bool starts_like(std::string_view text, std::string_view signature) {
  return text.substr(0, signature.size()) == signature.substr(0, text.size());
}

ImageHeader jpeg_header(Bytes bytes, const std::string& source) {
  const JpegHeader jpeg = read_jpeg_header(bytes, source);
  return {.format = ImageFormat::kJpeg, .size = {jpeg.width, jpeg.height}, .is_grey = jpeg.is_grey};
}

// The first chunk, IHDR (W3C PNG, 5.3 and 11.2.2): length, 4 bytes; type, 4; width, 4; height, 4;
// bit depth, 1; colour type, 1 (0 = grey). Numbers are big-endian.
ImageHeader png_header(Bytes bytes, const std::string& source) {
  const std::string_view text = text_of(bytes);
  constexpr std::size_t kType = 12, kWidth = 16, kHeight = 20, kDepth = 24, kColour = 25;
  if (text.size() <= kColour || text.substr(kType, 4) != "IHDR") {
    throw_damaged_image(source, "no PNG header");
  }
  const auto number = [&](std::size_t at) {
    std::int64_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value = value << 8 | static_cast<std::uint8_t>(text[at + i]);
    return value;
  };
  const std::int64_t width = number(kWidth), height = number(kHeight);
  if (std::min(width, height) < 1 || std::max(width, height) > std::numeric_limits<int>::max()) {
    throw_damaged_image(source, fmt::format("{}x{} pixels", width, height));
  }
  return {.format = ImageFormat::kPng,
          .size = {static_cast<int>(width), static_cast<int>(height)},
          .bits_per_channel = text[kDepth],
          .is_grey = text[kColour] == 0};
}

}  // namespace

ImageHeader parse_image_header(Bytes bytes, const std::string& source) {
  if (bytes.empty()) throw Error(source + ": empty file; capture or copy it again");
  const bool is_jpeg = starts_like(text_of(bytes), kJpegSignature);
  if (!is_jpeg && !starts_like(text_of(bytes), kPngSignature)) {
    throw Error(source + ": not an image Raywalk reads; JPEG or PNG is needed");
  }
  ImageHeader header = is_jpeg ? jpeg_header(bytes, source) : png_header(bytes, source);
  const int orientation =
      static_cast<int>(ExifTags(bytes).number(EXIF_TAG_ORIENTATION).value_or(1));
  if (orientation >= 1 && orientation <= 8) header.orientation = orientation;
  return header;
}

void throw_damaged_image(const std::string& source, const std::string& reason) {
  throw Error(fmt::format("{}: the image is damaged or cut short ({}); capture or copy it again",
                          source, one_line(reason)));
}

}  // namespace raywalk
