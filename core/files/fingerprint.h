// Checksums, and what tells whether inputs are still those that earlier results were made from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace cv {
class Mat;
}

namespace raywalk {

// SHA-256, as lower-case hexadecimal.
std::string sha256_hex(std::span<const std::byte> bytes);
std::string sha256_hex(std::string_view text);

// The same of a file's bytes. Throws Error as read_file() does.
std::string sha256_of_file(const std::filesystem::path& file);

// The same of the pixels' bytes, row by row from the top, all channels, whether or not there are
// gaps between the rows in memory. Any type, at most two dimensions.
std::string sha256_of_pixels(const cv::Mat& picture);

// Tells a changed file without reading it.
struct FileStamp {
  std::uintmax_t bytes = 0;
  std::int64_t time = 0;  // of the last write: ns since the epoch of std::filesystem's file clock

  std::string text() const;  // "BYTES TIME"
};

// Throws Error naming the file where it is missing or is not a plain file.
FileStamp stamp_of(const std::filesystem::path& file);

}  // namespace raywalk
