#include "core/report/data_uri.h"

#include <openssl/evp.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/base/error.h"

namespace raywalk {
namespace {

constexpr int kOldQuality = 90;

// EVP_EncodeBlock takes the length as int; a multiple of 3 bytes encodes without padding, so that
// blocks can be put one after another.
constexpr std::size_t kBlockBytes = 3 * (std::size_t{1} << 20);

std::string base64(std::span<const unsigned char> bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  std::vector<unsigned char> encoded(kBlockBytes / 3 * 4 + 1);  // and the NUL it writes
  while (!bytes.empty()) {
    const std::span<const unsigned char> block = bytes.first(std::min(bytes.size(), kBlockBytes));
    const int length =
        EVP_EncodeBlock(encoded.data(), block.data(), static_cast<int>(block.size()));
    text.append(encoded.begin(), encoded.begin() + length);
    bytes = bytes.subspan(block.size());
  }
  return text;
}

}  // namespace

std::string data_uri(std::span<const unsigned char> bytes, std::string_view media_type) {
  return "data:" + std::string(media_type) + ";base64," + base64(bytes);
}

std::string data_uri(const cv::Mat& image, EmbeddedFormat format) {
  if (image.empty() || (image.type() != CV_8UC1 && image.type() != CV_8UC3)) {
    throw Error("report: an embedded picture must be 8-bit grey or colour and not empty");
  }
  std::vector<unsigned char> file;
  if (format == EmbeddedFormat::kPng) {
    cv::imencode(".png", image, file);
    return data_uri(file, "image/png");
  }
  cv::imencode(".jpg", image, file, {cv::IMWRITE_JPEG_QUALITY, kOldQuality});
  return data_uri(file, "image/jpeg");
}

}  // namespace raywalk
