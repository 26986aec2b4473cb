// For tests: pictures as a camera writes them to its card.
#pragma once

#include <exiv2/exiv2.hpp>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>

namespace raywalk::capture {

// A small picture of one colour, of the format that the extension names.
inline void write_test_picture(const std::filesystem::path& file, int width = 64, int height = 32,
                               int level = 128) {
  cv::imwrite(file.string(), cv::Mat(height, width, CV_8UC3, cv::Scalar::all(level)));
}

// Exif text by tag number, group "Photo" (0x9003 DateTimeOriginal, 0x9291 SubSecTimeOriginal,
// 0x9011 OffsetTimeOriginal).
inline void write_test_exif(const std::filesystem::path& file,
                            const std::map<int, std::string>& tags) {
  const auto image = Exiv2::ImageFactory::open(file.string());
  image->readMetadata();
  Exiv2::ExifData exif;
  for (const auto& [tag, text] : tags) {
    const Exiv2::AsciiValue value(text);
    exif.add(Exiv2::ExifKey(static_cast<std::uint16_t>(tag), "Photo"), &value);
  }
  image->setExifData(exif);
  image->writeMetadata();
}

}  // namespace raywalk::capture
