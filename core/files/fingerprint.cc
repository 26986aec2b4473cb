#include "core/files/fingerprint.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <fstream>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk {
namespace {

constexpr std::streamsize kBlockBytes = std::streamsize{1} << 20;

// The checksum of bytes that arrive in pieces.
class Sha256 {
 public:
  Sha256() { require(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr)); }

  void add(std::span<const std::byte> bytes) {
    require(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()));
  }

  // Of all bytes added; to be called once, last.
  std::string hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest = {};
    unsigned int digest_bytes = 0;
    require(EVP_DigestFinal_ex(context_.get(), digest.data(), &digest_bytes));
    std::string hex;
    for (unsigned int i = 0; i < digest_bytes; ++i) hex += fmt::format("{:02x}", digest[i]);
    return hex;
  }

 private:
  static void require(int result) {
    if (result != 1) throw Error("OpenSSL cannot compute SHA-256; check its configuration");
  }

  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

}  // namespace

std::string sha256_hex(std::span<const std::byte> bytes) {
  Sha256 sha256;
  sha256.add(bytes);
  return sha256.hex();
}

std::string sha256_hex(std::string_view text) { return sha256_hex(std::as_bytes(std::span(text))); }

std::string sha256_of_file(const std::filesystem::path& file) {
  const std::uintmax_t bytes = stamp_of(file).bytes;
  std::ifstream stream(file, std::ios::binary);
  std::vector<char> block(kBlockBytes);
  std::uintmax_t read = 0;
  Sha256 sha256;
  while (stream.read(block.data(), kBlockBytes), stream.gcount() > 0) {
    throw_if_interrupted();
    const auto count = static_cast<std::size_t>(stream.gcount());
    sha256.add(std::as_bytes(std::span(block).first(count)));
    read += count;
  }
  if (read != bytes) throw Error("cannot read " + file.string() + " to its end");
  return sha256.hex();
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
