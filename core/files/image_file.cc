#include "core/files/image_file.h"

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/standard_streams.h"
#include "core/files/atomic_output.h"
#include "core/files/image_header.h"
#include "core/files/jpeg_decoder.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// Of most files, and of those with an EXIF block and previews before the size; longer headers are
// rare.
constexpr std::size_t kHeaderPrefixBytes[] = {std::size_t{4} << 10, std::size_t{256} << 10};

constexpr int kUsualQuality = 95;  // OpenCV's of JPEG

[[noreturn]] void throw_truncated(const fs::path& file) {
  throw Error(file.string() + ": the image is cut short; capture or copy it again");
}

std::optional<ImageHeader> header_of(const std::string& bytes, const fs::path& file) {
  return parse_image_header(std::as_bytes(std::span(bytes)), file.string());
}

std::string size_text(std::int64_t width, std::int64_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

void require_picture(const ImageHeader& header, const fs::path& file) {
  // PNG sizes go up to 2^32, those of cv::Mat up to 2^31.
  if (std::max(header.width, header.height) > std::numeric_limits<int>::max()) {
    throw Error(file.string() + ": " + size_text(header.width, header.height) + " is too large");
  }
  if (header.bits_per_channel > 8) {
    throw Error(file.string() + ": " + std::to_string(header.bits_per_channel) +
                " bits per channel; frames have 8");
  }
}

void require_panorama(const ImageHeader& header, const fs::path& file) {
  if (header.width != 2 * header.height) {
    throw Error(file.string() + ": " + size_text(header.width, header.height) +
                " is not a panorama; its width must be twice its height");
  }
  require_picture(header, file);
}

void require_distance_map(const ImageHeader& header, const fs::path& file) {
  if (header.format != ImageFormat::kPng || header.bits_per_channel != 16 || !header.is_grey) {
    throw Error(file.string() +
                ": not a 16-bit grey PNG; distance maps are, in millimetres along the ray");
  }
}

void require_mask(const ImageHeader& header, const fs::path& file, PanoramaSize size) {
  if (!header.is_grey || header.bits_per_channel > 8) {
    throw Error(file.string() + ": not an 8-bit grey image; masks are");
  }
  if (header.width != size.width || header.height != size.height) {
    throw Error(file.string() + ": the mask is " + size_text(header.width, header.height) +
                ", but " + size_text(size.width, size.height) + " is needed");
  }
}

// The bytes of a complete image file, and its header.
struct EncodedImage {
  std::string bytes;
  ImageHeader header;
};

// Checks for the end of the image first: OpenCV decodes a truncated file without an error and
// leaves the rest grey or black.
EncodedImage encoded_image(std::string bytes, const fs::path& file) {
  EncodedImage image;
  image.bytes = std::move(bytes);
  const auto header = header_of(image.bytes, file);
  if (!header || !is_complete_image(std::as_bytes(std::span(image.bytes)), header->format)) {
    throw_truncated(file);
  }
  image.header = *header;
  return image;
}

EncodedImage read_encoded(const fs::path& file) { return encoded_image(read_file(file), file); }

[[noreturn]] void throw_damaged(const fs::path& file, const std::string& words) {
  throw Error(file.string() +
              ": cannot be decoded: the picture is damaged; capture or copy it again" +
              (words.empty() ? "" : " (" + words + ")"));
}

cv::Mat decode_png(std::string& encoded, int flags, const fs::path& file) {
  try {
    const CapturedErrors captured;  // the decoder knows no file
    const cv::Mat bytes(1, static_cast<int>(encoded.size()), CV_8UC1, encoded.data());
    cv::Mat picture = cv::imdecode(bytes, flags);
    if (picture.empty()) throw_damaged(file, one_line(captured.text()));
    return picture;
  } catch (const cv::Exception& e) {
    throw_damaged(file, one_line(e.err));
  }
}

cv::Mat decode(EncodedImage& image, int flags, int type, const fs::path& file) {
  cv::Mat picture =
      image.header.format == ImageFormat::kPng
          ? decode_png(image.bytes, flags, file)
          : decode_jpeg(std::as_bytes(std::span(image.bytes)),
                        type == CV_8UC1 ? JpegColours::kGrey : JpegColours::kBgr, file.string());
  if (picture.cols != image.header.width || picture.rows != image.header.height ||
      picture.type() != type) {
    throw_damaged(file, "");
  }
  return picture;
}

std::string lower_case_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_one_of(const std::string& extension, std::initializer_list<const char*> others) {
  return std::find(others.begin(), others.end(), extension) != others.end();
}

// OpenCV would silently convert types that a format does not support, changing the values.
void require_encodable(const fs::path& file, const cv::Mat& image) {
  const std::string extension = lower_case_extension(file);
  const bool is_deep = is_one_of(extension, {".png", ".tif", ".tiff"});
  if (!is_deep && !is_one_of(extension, {".jpg", ".jpeg", ".webp"})) {
    throw UsageError(file.string() +
                     ": unknown image format; end the name in .png, .jpg, .webp or .tif");
  }
  const bool has_channels = image.channels() == 1 || image.channels() == 3;
  const bool has_depth = image.depth() == CV_8U || (is_deep && image.depth() == CV_16U);
  if (image.empty() || !has_channels || !has_depth) {
    throw Error(file.string() + ": cannot hold a " + size_text(image.cols, image.rows) +
                " picture of OpenCV type " + cv::typeToString(image.type()));
  }
}

std::vector<int> encoding_parameters(const std::string& extension, std::optional<int> quality) {
  if (extension == ".webp") return {cv::IMWRITE_WEBP_QUALITY, quality.value_or(kUsualQuality)};
  if (quality) return {cv::IMWRITE_JPEG_QUALITY, *quality};
  return {};
}

cv::Mat decode_colours(EncodedImage& image, const fs::path& file) {
  return decode(image, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION, CV_8UC3, file);
}

ImageHeader read_header(const fs::path& file) {
  for (const std::size_t bytes : kHeaderPrefixBytes) {
    if (const auto header = header_of(read_file_prefix(file, bytes), file)) return *header;
  }
  const auto header = header_of(read_file(file), file);
  if (!header) throw_truncated(file);
  return *header;
}

PictureHeader picture_header(const ImageHeader& header) {
  return {{static_cast<int>(header.width), static_cast<int>(header.height)}, header.orientation};
}

}  // namespace

cv::Mat read_panorama(const fs::path& file) {
  EncodedImage image = read_encoded(file);
  require_panorama(image.header, file);
  return decode_colours(image, file);
}

cv::Mat read_picture(const fs::path& file) {
  EncodedImage image = read_encoded(file);
  require_picture(image.header, file);
  return decode_colours(image, file);
}

cv::Mat read_distance_map(const fs::path& file) {
  EncodedImage image = read_encoded(file);
  require_distance_map(image.header, file);
  return decode(image, cv::IMREAD_UNCHANGED, CV_16UC1, file);
}

cv::Mat read_mask(const fs::path& file, PanoramaSize size) {
  EncodedImage image = read_encoded(file);
  require_mask(image.header, file, size);
  return decode(image, cv::IMREAD_GRAYSCALE, CV_8UC1, file);
}

void require_mask(const fs::path& file, PanoramaSize size) {
  require_mask(read_header(file), file, size);
}

PictureHeader panorama_header_of(const fs::path& file) {
  const ImageHeader header = read_header(file);
  require_panorama(header, file);
  return picture_header(header);
}

PanoramaSize panorama_size_of(const fs::path& file) { return panorama_header_of(file).size; }

PictureHeader picture_header_of(const fs::path& file) {
  const ImageHeader header = read_header(file);
  require_picture(header, file);
  return picture_header(header);
}

PanoramaSize picture_size_of(const fs::path& file) { return picture_header_of(file).size; }

void require_intact_image(std::string bytes, const std::string& source) {
  EncodedImage image = encoded_image(std::move(bytes), source);
  if (image.header.format == ImageFormat::kJpeg) {
    require_intact_jpeg(std::as_bytes(std::span(image.bytes)), source);
  } else {
    decode_png(image.bytes, cv::IMREAD_UNCHANGED, source);
  }
}

std::vector<unsigned char> encode_image(const fs::path& file, const cv::Mat& image,
                                        std::optional<int> quality) {
  require_encodable(file, image);
  const std::string extension = lower_case_extension(file);
  std::vector<unsigned char> bytes;
  bool encoded = false;
  try {
    encoded = cv::imencode(extension, image, bytes, encoding_parameters(extension, quality));
  } catch (const cv::Exception& e) {
    throw Error("cannot write " + file.string() + ": the picture cannot be encoded (" +
                one_line(e.err) + ")");
  }
  if (!encoded) {
    throw Error("cannot write " + file.string() + ": a " + size_text(image.cols, image.rows) +
                " picture is more than its format can hold");
  }
  return bytes;
}

void write_image(const fs::path& file, const cv::Mat& image) {
  // Encoded in memory first: cv::imwrite does not notice a full disk.
  const std::vector<unsigned char> bytes = encode_image(file, image);
  write_file_atomically(file, std::as_bytes(std::span(bytes)));
}

}  // namespace raywalk
