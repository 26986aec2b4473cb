#include "core/files/fingerprint.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <opencv2/core/mat.hpp>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {

std::string sha256_hex(std::span<const std::byte> bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest = {};
  unsigned int digest_bytes = 0;
  const int computed =
      EVP_Digest(bytes.data(), bytes.size(), digest.data(), &digest_bytes, EVP_sha256(), nullptr);
  if (computed != 1) throw Error("OpenSSL cannot compute SHA-256; check its configuration");
  std::string hex;
  for (unsigned int i = 0; i < digest_bytes; ++i) hex += fmt::format("{:02x}", digest[i]);
  return hex;
}

std::string sha256_hex(std::string_view text) { return sha256_hex(std::as_bytes(std::span(text))); }

std::string sha256_of_file(const std::filesystem::path& file) {
  return sha256_hex(read_file(file));
}

std::string sha256_of_pixels(const cv::Mat& picture) {
  const cv::Mat rows = picture.isContinuous() ? picture : picture.clone();
  return sha256_hex(std::as_bytes(std::span(rows.data, rows.total() * rows.elemSize())));
}

std::string FileStamp::text() const { return fmt::format("{} {}", bytes, time); }

FileStamp stamp_of(const std::filesystem::path& file) {
  std::error_code error;
  FileStamp stamp;
  stamp.bytes = std::filesystem::file_size(file, error);
  if (!error) {
    stamp.time = std::filesystem::last_write_time(file, error).time_since_epoch().count();
  }
  if (error) throw Error(fmt::format("{}: cannot be read ({})", file.string(), error.message()));
  return stamp;
}

}  // namespace raywalk
