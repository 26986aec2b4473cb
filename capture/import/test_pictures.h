// For tests: pictures as a camera writes them to its card.
#pragma once

#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/exif.h"

namespace raywalk::capture {

// A small picture of one colour, of the format that the extension names.
inline void write_test_picture(const std::filesystem::path& file, int width = 64, int height = 32,
                               int level = 128) {
  cv::imwrite(file.string(), cv::Mat(height, width, CV_8UC3, cv::Scalar::all(level)));
}

// What a camera that does not stitch writes: two image circles.
inline void write_test_circles(const std::filesystem::path& file) {
  cv::Mat picture(128, 256, CV_8UC3, cv::Scalar::all(0));
  for (const int x : {64, 192}) cv::circle(picture, {x, 64}, 62, cv::Scalar::all(160), cv::FILLED);
  cv::imwrite(file.string(), picture);
}

// Exif text by tag number (0x9003 DateTimeOriginal, 0x9291 SubSecTimeOriginal, 0x9011
// OffsetTimeOriginal), added to a JPEG file.
inline void write_test_exif(const std::filesystem::path& file,
                            const std::map<int, std::string>& tags) {
  std::vector<TiffEntry> entries;
  for (const auto& [tag, text] : tags) entries.push_back(ascii_entry(tag, text));
  write_file_atomically(
      file, with_app1(read_file(file), kExifIdentifier, exif_block({}, std::move(entries))));
}

}  // namespace raywalk::capture
