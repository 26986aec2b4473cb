// What tells whether inputs are still those that earlier results were made from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace cv {
class Mat;
}

namespace raywalk {

// Tells a changed file without reading it.
struct FileStamp {
  std::uintmax_t bytes = 0;
  std::int64_t time = 0;  // of the last write: ns since the epoch of std::filesystem's file clock

  // "BYTES TIME"; part of fingerprints on disk, so its form stays.
  std::string text() const;
};

// Throws Error naming the file where it is missing or is not a plain file.
FileStamp stamp_of(const std::filesystem::path& file);

// SHA-256, hexadecimal, of a file's bytes, read in pieces. Throws Error naming the file where it is
// missing, is not a plain file or cannot be read, and Interrupted.
std::string sha256_of_file(const std::filesystem::path& file);

// SHA-256, hexadecimal, of the pixels' bytes, row by row from the top, all channels; the same
// whether or not there are gaps between the rows in memory. Any type, at most two dimensions.
std::string sha256_of_pixels(const cv::Mat& picture);

}  // namespace raywalk
