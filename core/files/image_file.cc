#include "core/files/image_file.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/exif.h"
#include "core/files/jpeg.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using Bytes = std::span<const std::byte>;

// Of nearly all files, also of those with previews before the size.
constexpr std::size_t kHeaderPrefixBytes = std::size_t{128} << 10;
constexpr int kUsualQuality = 95;  // OpenCV's of JPEG
constexpr std::string_view kJpegSignature = "\xFF\xD8\xFF";
constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1A\n";

Bytes bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

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

// Numbers of PNG.
std::uint32_t big_endian(std::string_view text, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<std::uint8_t>(text[i]);
  return value;
}

// The first chunk, IHDR (W3C PNG, 5.3 and 11.2.2): length, 4 bytes; type, 4; width, 4; height, 4;
// bit depth, 1; colour type, 1 (0 = grey).
ImageHeader png_header(Bytes bytes, const std::string& source) {
  const std::string_view text = text_of(bytes);
  constexpr std::size_t kType = 12, kWidth = 16, kHeight = 20, kDepth = 24, kColour = 25;
  if (text.size() <= kColour || text.substr(kType, 4) != "IHDR") {
    throw_damaged_image(source, "no PNG header");
  }
  const std::uint32_t width = big_endian(text, kWidth), height = big_endian(text, kHeight);
  if (std::min(width, height) < 1 || std::max(width, height) > std::numeric_limits<int>::max()) {
    throw_damaged_image(source, fmt::format("{}x{} pixels", width, height));
  }
  return {.format = ImageFormat::kPng,
          .size = {static_cast<int>(width), static_cast<int>(height)},
          .bits_per_channel = text[kDepth],
          .is_grey = text[kColour] == 0};
}

// Up to the last chunk, IEND, each has its length, 4 bytes; type, 4; data; and the checksum of
// both, 4 (W3C PNG, 5.3). Looked through first, as libpng prints what it finds on stderr.
void require_whole_chunks(std::string_view text, const std::string& source) {
  constexpr std::size_t kLength = 4, kType = 4, kChecksum = 4;
  std::string_view type;
  for (std::size_t at = kPngSignature.size(); type != "IEND";) {
    const std::size_t left = text.size() - at;
    const std::size_t rest = left < kLength ? 0 : big_endian(text, at) + kType + kChecksum;
    if (rest == 0 || left - kLength < rest) throw_damaged_image(source, "its end is missing");
    const std::string_view chunk = text.substr(at + kLength, rest - kChecksum);
    const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(chunk.data()), chunk.size());
    if (sum != big_endian(text, at + kLength + chunk.size())) {
      throw_damaged_image(source, "a checksum is wrong");
    }
    type = chunk.substr(0, kType);
    at += kLength + rest;
  }
}

ImageHeader read_header(const fs::path& file) {
  const std::string start = read_file_prefix(file, kHeaderPrefixBytes);
  try {
    return parse_image_header(bytes_of(start), file.string());
  } catch (const Error&) {
    if (start.size() < kHeaderPrefixBytes) throw;
  }
  return parse_image_header(bytes_of(read_file(file)), file.string());
}

void require_8_bits(const ImageHeader& header, const fs::path& file) {
  if (header.bits_per_channel <= 8) return;
  throw Error(fmt::format("{}: {} bits per channel; frames have 8", file.string(),
                          header.bits_per_channel));
}

bool is_2_to_1(PanoramaSize size) { return size.width == 2 * std::int64_t{size.height}; }

void require_panorama(const ImageHeader& header, const fs::path& file) {
  if (!is_2_to_1(header.size)) {
    throw Error(fmt::format("{}: {}x{} is not a panorama; its width must be twice its height",
                            file.string(), header.size.width, header.size.height));
  }
  require_8_bits(header, file);
}

void require_distance_map(const ImageHeader& header, const fs::path& file) {
  if (header.format == ImageFormat::kPng && header.bits_per_channel == 16 && header.is_grey) return;
  throw Error(file.string() +
              ": not a 16-bit grey PNG; distance maps are, in millimetres along the ray");
}

void require_mask(const ImageHeader& header, const fs::path& file, PanoramaSize size) {
  if (!header.is_grey || header.bits_per_channel > 8) {
    throw Error(file.string() + ": not an 8-bit grey image; masks are");
  }
  if (header.size == size) return;
  throw Error(fmt::format("{}: the mask is {}x{}, but {}x{} is needed", file.string(),
                          header.size.width, header.size.height, size.width, size.height));
}

cv::Mat decode_png(Bytes bytes, int flags, const std::string& source) {
  require_whole_chunks(text_of(bytes), source);
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

// The image as `type`, CV_8UC3, CV_8UC1 or CV_16UC1, of a file whose header fits that.
cv::Mat decode(const std::string& bytes, ImageFormat format, int type, const fs::path& file) {
  if (format == ImageFormat::kJpeg) {
    return decode_jpeg(bytes_of(bytes), type, file.string());
  }
  const int flags = type == CV_8UC3   ? cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION
                    : type == CV_8UC1 ? cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION
                                      : cv::IMREAD_UNCHANGED;
  cv::Mat image = decode_png(bytes_of(bytes), flags, file.string());
  if (image.type() != type) throw_damaged_image(file.string(), cv::typeToString(image.type()));
  return image;
}

// Reads a file whose header `require` accepts.
template <typename Require>
cv::Mat read_image(const fs::path& file, int type, Require require) {
  const std::string bytes = read_file(file);
  const ImageHeader header = parse_image_header(bytes_of(bytes), file.string());
  require(header, file);
  return decode(bytes, header.format, type, file);
}

std::string lower_case_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

// OpenCV would silently convert types that a format does not support, changing the values.
void require_encodable(const fs::path& file, const std::string& extension, const cv::Mat& image) {
  constexpr std::array<std::string_view, 6> kFormats = {".png", ".tif",  ".tiff",
                                                        ".jpg", ".jpeg", ".webp"};
  const auto format = std::ranges::find(kFormats, extension);
  if (format == kFormats.end()) {
    throw UsageError(file.string() +
                     ": unknown image format; end the name in .png, .jpg, .webp or .tif");
  }
  const bool is_deep = format < kFormats.begin() + 3;
  const bool has_channels = image.channels() == 1 || image.channels() == 3;
  const bool has_depth = image.depth() == CV_8U || (is_deep && image.depth() == CV_16U);
  if (image.empty() || !has_channels || !has_depth) {
    throw Error(fmt::format("{}: cannot hold a {}x{} image of OpenCV type {}", file.string(),
                            image.cols, image.rows, cv::typeToString(image.type())));
  }
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

cv::Mat read_panorama(const fs::path& file) { return read_image(file, CV_8UC3, require_panorama); }

cv::Mat read_picture(const fs::path& file) { return read_image(file, CV_8UC3, require_8_bits); }

cv::Mat read_distance_map(const fs::path& file) {
  return read_image(file, CV_16UC1, require_distance_map);
}

cv::Mat read_mask(const fs::path& file, PanoramaSize size) {
  return read_image(file, CV_8UC1, [&](const ImageHeader& header, const fs::path& mask) {
    require_mask(header, mask, size);
  });
}

void require_mask(const fs::path& file, PanoramaSize size) {
  require_mask(read_header(file), file, size);
}

ImageHeader panorama_header_of(const fs::path& file) {
  const ImageHeader header = read_header(file);
  require_panorama(header, file);
  return header;
}

ImageHeader picture_header_of(const fs::path& file) {
  const ImageHeader header = read_header(file);
  require_8_bits(header, file);
  return header;
}

PanoramaSize distance_map_size_of(const fs::path& file) {
  const ImageHeader header = read_header(file);
  require_distance_map(header, file);
  if (!is_2_to_1(header.size)) {
    throw Error(fmt::format("{}: {}x{} is not 2:1, as distance maps must be", file.string(),
                            header.size.width, header.size.height));
  }
  return header.size;
}

void TurnedPictures::add(const fs::path& file, int orientation) {
  if (orientation == 1 || count_++ > 0) return;
  first_ = file;
  first_orientation_ = orientation;
}

void TurnedPictures::warn() const {
  if (count_ == 0) return;
  const std::string others = count_ == 1 ? "" : fmt::format(", as in {} more pictures", count_ - 1);
  spdlog::warn(
      "{}: its EXIF orientation {} is ignored{}: pixels are used as they are stored; if only "
      "viewers show the pictures upright, turn their pixels first, for example with exiftran -ai",
      first_.string(), first_orientation_, others);
}

ImageHeader require_intact_image(Bytes bytes, const std::string& source) {
  const ImageHeader header = parse_image_header(bytes, source);
  if (header.format == ImageFormat::kJpeg) {
    require_intact_jpeg(bytes, source);
  } else {
    decode_png(bytes, cv::IMREAD_UNCHANGED, source);
  }
  return header;
}

std::vector<unsigned char> encode_image(const fs::path& file, const cv::Mat& image,
                                        std::optional<int> quality) {
  const std::string extension = lower_case_extension(file);
  require_encodable(file, extension, image);
  std::vector<int> parameters;
  if (extension == ".webp")
    parameters = {cv::IMWRITE_WEBP_QUALITY, quality.value_or(kUsualQuality)};
  if (extension != ".webp" && quality) parameters = {cv::IMWRITE_JPEG_QUALITY, *quality};
  std::vector<unsigned char> bytes;
  std::string reason = "more than its format can hold";
  try {
    if (cv::imencode(extension, image, bytes, parameters)) return bytes;
  } catch (const cv::Exception& e) {
    reason = one_line(e.err);
  }
  throw Error(fmt::format("cannot write {}: a {}x{} image cannot be encoded ({})", file.string(),
                          image.cols, image.rows, reason));
}

void write_image(const fs::path& file, const cv::Mat& image) {
  // Encoded in memory first: cv::imwrite does not notice a full disk.
  const std::vector<unsigned char> bytes = encode_image(file, image);
  write_file_atomically(file, std::as_bytes(std::span(bytes)));
}

}  // namespace raywalk
