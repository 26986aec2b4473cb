#include "core/files/image_file.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/colour_profile.h"
#include "core/files/exif.h"
#include "core/files/jpeg.h"
#include "core/files/png.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using Bytes = std::span<const std::byte>;

// Of nearly all files, also of those with previews before the size.
constexpr std::size_t kHeaderPrefixBytes = std::size_t{128} << 10;
constexpr int kUsualQuality = 95;  // OpenCV's of JPEG
constexpr double kMasked = 127.0;  // levels up to this are masked: JPEG changes black a little
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

ImageHeader png_image_header(Bytes bytes, const std::string& source) {
  const PngHeader png = read_png_header(bytes, source);
  return {.format = ImageFormat::kPng,
          .size = {png.width, png.height},
          .bits_per_channel = png.bits_per_channel,
          .is_grey = png.is_grey,
          .has_alpha = png.has_alpha};
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
  if (header.is_cropped) {
    throw Error(file.string() +
                ": shows a part of the sphere (its GPano tags state a cropped area); fill it up to "
                "the whole sphere, the rest transparent or masked, and remove these tags");
  }
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

void require_grey_mask(const ImageHeader& header, const fs::path& file) {
  if (header.is_grey && header.bits_per_channel <= 8) return;
  throw Error(file.string() + ": not an 8-bit grey image; masks are");
}

void require_mask_size(const ImageHeader& header, const fs::path& file, PanoramaSize size) {
  if (header.size == size) return;
  throw Error(fmt::format("{}: the mask is {}x{}, but {}x{} is needed", file.string(),
                          header.size.width, header.size.height, size.width, size.height));
}

// The image as `type`, CV_8UC3, CV_8UC1 or CV_16UC1, of a file whose header fits that, as stored.
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

// The alpha channel of a file that has one, CV_8UC1.
cv::Mat alpha_of(const std::string& bytes, const fs::path& file) {
  const cv::Mat image = decode_png(bytes_of(bytes), cv::IMREAD_UNCHANGED, file.string());
  cv::Mat alpha(image.size(), CV_8UC1, cv::Scalar(255));
  if (image.channels() != 4) return alpha;
  cv::extractChannel(image, alpha, 3);
  if (alpha.depth() == CV_16U) alpha.convertTo(alpha, CV_8U, 1.0 / 257.0);
  return alpha;
}

// Reads a file whose header `require` accepts.
template <typename Require>
cv::Mat read_image(const fs::path& file, int type, Require require) {
  const std::string bytes = read_file(file);
  const ImageHeader header = parse_image_header(bytes_of(bytes), file.string());
  require(header, file);
  cv::Mat image = decode(bytes, header.format, type, file);
  if (type == CV_8UC3) convert_to_srgb(embedded_profile(bytes_of(bytes)), &image);
  return image;
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
  ImageHeader header = is_jpeg ? jpeg_header(bytes, source) : png_image_header(bytes, source);
  const int orientation =
      static_cast<int>(ExifTags(bytes).number(EXIF_TAG_ORIENTATION).value_or(1));
  if (orientation >= 1 && orientation <= 8) header.orientation = orientation;
  header.attitude = stated_attitude(bytes);
  header.is_cropped = is_stated_as_cropped(bytes);
  return header;
}

cv::Mat read_panorama(const fs::path& file) { return read_image(file, CV_8UC3, require_panorama); }

cv::Mat read_picture(const fs::path& file) { return read_image(file, CV_8UC3, require_8_bits); }

cv::Mat read_distance_map(const fs::path& file) {
  return read_image(file, CV_16UC1, require_distance_map);
}

cv::Mat read_mask(const fs::path& file, PanoramaSize size) {
  const std::string bytes = read_file(file);
  const ImageHeader header = parse_image_header(bytes_of(bytes), file.string());
  require_mask_size(header, file, size);
  cv::Mat mask;
  if (header.has_alpha) {
    mask = alpha_of(bytes, file);
  } else {
    require_grey_mask(header, file);
    mask = decode(bytes, header.format, CV_8UC1, file);
  }
  double darkest = 0.0, lightest = 0.0;
  cv::minMaxLoc(mask, &darkest, &lightest);
  // Some tools write 0 and 1.
  cv::threshold(mask, mask, lightest == 1.0 ? 0.0 : kMasked, 255.0, cv::THRESH_BINARY);
  return mask;
}

void require_mask(const fs::path& file, PanoramaSize size) {
  const ImageHeader header = read_header(file);
  require_grey_mask(header, file);
  require_mask_size(header, file, size);
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
