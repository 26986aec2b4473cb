#include "core/files/fingerprint.h"

#include <fmt/format.h>

#include <opencv2/core/mat.hpp>
#include <span>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/sha256.h"

namespace raywalk {

namespace fs = std::filesystem;

std::string FileStamp::text() const { return fmt::format("{} {}", bytes, time); }

FileStamp stamp_of(const fs::path& file) {
  std::error_code error;
  FileStamp stamp;
  stamp.bytes = fs::file_size(file, error);
  if (!error) stamp.time = fs::last_write_time(file, error).time_since_epoch().count();
  if (error) throw Error(fmt::format("{}: cannot be read ({})", file.string(), error.message()));
  return stamp;
}

std::string sha256_of_file(const fs::path& file) { return sha256_hex(read_file(file)); }

std::string sha256_of_pixels(const cv::Mat& picture) {
  const cv::Mat rows = picture.isContinuous() ? picture : picture.clone();
  return sha256_hex(std::as_bytes(std::span(rows.data, rows.total() * rows.elemSize())));
}

}  // namespace raywalk
