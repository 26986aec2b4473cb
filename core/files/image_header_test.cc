#include "core/files/image_header.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/files/exif.h"

namespace raywalk {
namespace {

std::string encoded(const std::string& extension, int width, int height, int type,
                    const std::vector<int>& parameters = {}) {
  std::vector<unsigned char> bytes;
  cv::imencode(extension, cv::Mat(height, width, type, cv::Scalar(30, 60, 90)), bytes, parameters);
  return {bytes.begin(), bytes.end()};
}

ImageHeader header_of(const std::string& bytes) {
  return parse_image_header(std::as_bytes(std::span(bytes)), "a.jpg");
}

TEST(ImageHeader, ReadsWhatTheEncoderWrote) {
  for (const int progressive : {0, 1}) {
    const ImageHeader jpeg =
        header_of(encoded(".jpg", 300, 150, CV_8UC3, {cv::IMWRITE_JPEG_PROGRESSIVE, progressive}));
    EXPECT_EQ(jpeg.format, ImageFormat::kJpeg);
    EXPECT_EQ(jpeg.size, (PanoramaSize{300, 150}));
    EXPECT_EQ(jpeg.bits_per_channel, 8);
    EXPECT_FALSE(jpeg.is_grey);
    EXPECT_EQ(jpeg.orientation, 1);
  }
  EXPECT_TRUE(header_of(encoded(".jpg", 8, 4, CV_8UC1)).is_grey);
  const ImageHeader png = header_of(encoded(".png", 70000, 2, CV_16UC1));
  EXPECT_EQ(png.format, ImageFormat::kPng);
  EXPECT_EQ(png.size, (PanoramaSize{70000, 2}));
  EXPECT_EQ(png.bits_per_channel, 16);
  EXPECT_TRUE(png.is_grey);
  EXPECT_FALSE(header_of(encoded(".png", 4, 2, CV_8UC3)).is_grey);
}

// The first directory of a TIFF block of either byte order has the orientation as second entry.
std::string block_with(char orientation, bool little_endian) {
  if (little_endian) {
    return exif_block({ascii_entry(EXIF_TAG_MAKE, "a"),
                       short_entry(EXIF_TAG_ORIENTATION, static_cast<std::uint16_t>(orientation))},
                      {});
  }
  std::string block(
      "MM\0*\0\0\0\x08\0\x02\x01\x0F\0\x02\0\0\0\x01\0\0\0\0\x01\x12\0\x03\0\0\0\x01\0?"
      "\0\0\0\0\0\0",
      38);
  return block.replace(block.find('?'), 1, 1, orientation);
}

std::string jpeg_with(const std::string& block) {
  return with_app1(encoded(".jpg", 64, 32, CV_8UC3), kExifIdentifier, block);
}

std::string png_with(const std::string& block) {
  std::string png = encoded(".png", 64, 32, CV_8UC3);
  const std::string size(1, static_cast<char>(block.size()));
  // Behind IHDR; the checksum is not read.
  return png.insert(33, std::string(3, '\0') + size + "eXIf" + block + std::string(4, '\0'));
}

TEST(ImageHeader, OrientationIsReadFromExif) {
  for (const bool little_endian : {false, true}) {
    for (char orientation = 1; orientation <= 8; ++orientation) {
      const std::string block = block_with(orientation, little_endian);
      EXPECT_EQ(header_of(jpeg_with(block)).orientation, orientation);
      EXPECT_EQ(header_of(png_with(block)).orientation, orientation);
    }
  }
}

TEST(ImageHeader, DamagedExifIsUpright) {
  const std::string whole = block_with(6, true);
  for (std::size_t length = 0; length < 22; ++length) {
    EXPECT_EQ(header_of(jpeg_with(whole.substr(0, length))).orientation, 1) << length;
  }
  for (const char bad : {char{0}, char{9}, static_cast<char>(255)}) {
    EXPECT_EQ(header_of(jpeg_with(block_with(bad, true))).orientation, 1);
  }
  std::string beyond = whole;
  beyond[4] = beyond[7] = static_cast<char>(0xFF);  // the directory's offset
  EXPECT_EQ(header_of(jpeg_with(beyond)).orientation, 1);
}

// As an EXIF preview is.
TEST(ImageHeader, AnImageInsideTheHeaderIsSkipped) {
  const std::string preview = encoded(".jpg", 16, 8, CV_8UC3);
  EXPECT_EQ(header_of(with_app1(encoded(".jpg", 256, 128, CV_8UC3), "", preview)).size,
            (PanoramaSize{256, 128}));
}

TEST(ImageHeader, NonImagesAreRejected) {
  using namespace std::string_literals;
  EXPECT_THROW(header_of(""), Error);
  EXPECT_THROW(header_of("<!DOCTYPE html><html></html>"), Error);
  EXPECT_THROW(header_of(encoded(".bmp", 4, 2, CV_8UC3)), Error);
  EXPECT_THROW(header_of("\xFF\xD8\xFF\xD9"), Error) << "ends before it has a size";
  EXPECT_THROW(header_of("\xFF\xD8\xFF\xC0\0\4\10\0"s), Error) << "frame header too short";
  EXPECT_THROW(header_of("\xFF\xD8\xFF\xC0\0\x0B\x08\0\0\0\4\1\1\x11\0"s), Error) << "height 0";
  std::string huge = encoded(".png", 4, 2, CV_8UC3);
  EXPECT_THROW(header_of(huge.replace(16, 4, "\xFF\xFF\xFF\xFE")), Error);
}

TEST(ImageHeader, DamagedBytesAreAnErrorOrAHeaderNeverACrash) {
  std::mt19937 random(11);
  for (const std::string extension : {".jpg", ".png"}) {
    const std::string whole = encoded(extension, 32, 16, CV_8UC3);
    for (int i = 0; i < 5000; ++i) {
      std::string damaged = whole.substr(0, 1 + random() % whole.size());
      for (int change = 0; change < 4; ++change) {
        damaged[random() % damaged.size()] = static_cast<char>(random());
      }
      try {
        const ImageHeader header = header_of(damaged);
        EXPECT_GE(header.size.width, 1);
        EXPECT_GE(header.size.height, 1);
      } catch (const Error& e) {
        EXPECT_EQ(std::string(e.what()).rfind("a.jpg: ", 0), 0U);
      }
    }
  }
}

}  // namespace
}  // namespace raywalk
