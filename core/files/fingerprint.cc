#include "core/files/fingerprint.h"

#include <fmt/format.h>

#include <fstream>
#include <opencv2/core/mat.hpp>
#include <span>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/files/sha256.h"

namespace raywalk {

namespace fs = std::filesystem;

namespace {

constexpr std::streamsize kBlockBytes = std::streamsize{1} << 20;

}  // namespace

std::string FileStamp::text() const { return fmt::format("{} {}", bytes, time); }

FileStamp stamp_of(const fs::path& file) {
  std::error_code error;
  FileStamp stamp;
  stamp.bytes = fs::file_size(file, error);
  if (!error) stamp.time = fs::last_write_time(file, error).time_since_epoch().count();
  if (error) throw Error(fmt::format("{}: cannot be read ({})", file.string(), error.message()));
  return stamp;
}

std::string sha256_of_file(const fs::path& file) {
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

}  // namespace raywalk
