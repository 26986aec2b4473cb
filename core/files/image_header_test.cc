#include "core/files/image_header.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace raywalk {
namespace {

using Buffer = std::vector<unsigned char>;

Buffer encoded(const std::string& extension, int width, int height, int type,
               const std::vector<int>& parameters = {}) {
  Buffer bytes;
  cv::imencode(extension, cv::Mat(height, width, type, cv::Scalar(30, 60, 90)), bytes, parameters);
  return bytes;
}

std::span<const std::byte> as_bytes(const Buffer& buffer) {
  return std::as_bytes(std::span(buffer));
}

std::optional<ImageHeader> header_of(const Buffer& buffer) {
  return parse_image_header(as_bytes(buffer), "a.jpg");
}

TEST(ImageHeader, ReadsWhatTheEncoderWrote) {
  const auto jpeg = header_of(encoded(".jpg", 300, 150, CV_8UC3));
  ASSERT_TRUE(jpeg);
  EXPECT_EQ(jpeg->format, ImageFormat::kJpeg);
  EXPECT_EQ(jpeg->width, 300);
  EXPECT_EQ(jpeg->height, 150);
  EXPECT_EQ(jpeg->bits_per_channel, 8);
  EXPECT_FALSE(jpeg->is_grey);
  EXPECT_TRUE(header_of(encoded(".jpg", 8, 4, CV_8UC1))->is_grey);

  const auto png = header_of(encoded(".png", 70000, 2, CV_16UC1));
  ASSERT_TRUE(png);
  EXPECT_EQ(png->format, ImageFormat::kPng);
  EXPECT_EQ(png->width, 70000);
  EXPECT_EQ(png->height, 2);
  EXPECT_EQ(png->bits_per_channel, 16);
  EXPECT_TRUE(png->is_grey);
  EXPECT_FALSE(header_of(encoded(".png", 4, 2, CV_8UC3))->is_grey);
}

// A TIFF block whose first directory has the orientation as second entry.
Buffer tiff_with(unsigned char orientation, bool little_endian) {
  if (little_endian) {
    return {'I', 'I', 42, 0,    8, 0, 0, 0, 2, 0, 0x0F, 1,           2, 0, 1, 0, 0, 0, 0,
            0,   0,   0,  0x12, 1, 3, 0, 1, 0, 0, 0,    orientation, 0, 0, 0, 0, 0, 0, 0};
  }
  return {'M', 'M', 0, 42, 0,    0, 0, 8, 0, 2, 1, 0x0F, 0,           2, 0, 0, 0, 1, 0,
          0,   0,   0, 1,  0x12, 0, 3, 0, 0, 0, 1, 0,    orientation, 0, 0, 0, 0, 0, 0};
}

Buffer jpeg_with(const Buffer& tiff) {
  Buffer bytes = encoded(".jpg", 64, 32, CV_8UC3);
  Buffer segment = {0xFF, 0xE1, 0, static_cast<unsigned char>(8 + tiff.size()), 'E', 'x', 'i',
                    'f',  0,    0};
  segment.insert(segment.end(), tiff.begin(), tiff.end());
  bytes.insert(bytes.begin() + 2, segment.begin(), segment.end());
  return bytes;
}

Buffer png_with(const Buffer& tiff) {
  Buffer bytes = encoded(".png", 64, 32, CV_8UC3);
  Buffer chunk = {0, 0, 0, static_cast<unsigned char>(tiff.size()), 'e', 'X', 'I', 'f'};
  chunk.insert(chunk.end(), tiff.begin(), tiff.end());
  chunk.insert(chunk.end(), 4, 0);  // the checksum, which the header's reader does not need
  bytes.insert(bytes.begin() + 33, chunk.begin(), chunk.end());  // after IHDR
  return bytes;
}

TEST(ImageHeader, OrientationIsReadFromExif) {
  EXPECT_EQ(header_of(encoded(".jpg", 64, 32, CV_8UC3))->orientation, 1);
  for (const bool little_endian : {false, true}) {
    for (unsigned char orientation = 1; orientation <= 8; ++orientation) {
      const Buffer tiff = tiff_with(orientation, little_endian);
      EXPECT_EQ(header_of(jpeg_with(tiff))->orientation, orientation);
      EXPECT_EQ(header_of(png_with(tiff))->orientation, orientation);
    }
  }
}

TEST(ImageHeader, DamagedExifIsUpright) {
  const Buffer whole = tiff_with(6, true);
  for (std::size_t length = 0; length + 8 < whole.size(); ++length) {
    const Buffer cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_EQ(header_of(jpeg_with(cut))->orientation, 1) << length;
  }
  for (const unsigned char bad : {0, 9, 255}) {
    EXPECT_EQ(header_of(jpeg_with(tiff_with(bad, true)))->orientation, 1);
  }
  Buffer beyond = whole;
  beyond[4] = beyond[7] = 0xFF;  // the directory's offset
  EXPECT_EQ(header_of(jpeg_with(beyond))->orientation, 1);
}

TEST(ImageHeader, ProgressiveJpegIsReadAndFollowedToItsEnd) {
  const Buffer bytes = encoded(".jpg", 64, 32, CV_8UC3,
                               {cv::IMWRITE_JPEG_PROGRESSIVE, 1, cv::IMWRITE_JPEG_RST_INTERVAL, 1});
  ASSERT_TRUE(header_of(bytes));
  EXPECT_EQ(header_of(bytes)->width, 64);
  EXPECT_TRUE(is_complete_image(as_bytes(bytes), ImageFormat::kJpeg));
}

TEST(ImageHeader, NoPrefixIsComplete) {
  for (const std::string extension : {".jpg", ".png"}) {
    const Buffer whole = encoded(extension, 32, 16, CV_8UC3);
    const ImageFormat format = header_of(whole)->format;
    EXPECT_TRUE(is_complete_image(as_bytes(whole), format));
    for (std::size_t length = 1; length < whole.size(); ++length) {
      const Buffer cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
      const auto header = header_of(cut);
      EXPECT_TRUE(!header || header->width == 32);
      ASSERT_FALSE(is_complete_image(as_bytes(cut), format)) << extension << " " << length;
    }
  }
}

TEST(ImageHeader, DataAfterTheEndIsLegal) {
  for (const std::string extension : {".jpg", ".png"}) {
    Buffer bytes = encoded(extension, 32, 16, CV_8UC3);
    bytes.insert(bytes.end(), 100000, 0x55);
    EXPECT_TRUE(is_complete_image(as_bytes(bytes), header_of(bytes)->format));
  }
}

// An application segment that holds a whole little JPEG, as an EXIF preview does.
Buffer with_preview(const Buffer& jpeg, const Buffer& preview) {
  const std::size_t length = preview.size() + 2;
  Buffer bytes = {0xFF,
                  0xD8,
                  0xFF,
                  0xE1,
                  static_cast<unsigned char>(length >> 8),
                  static_cast<unsigned char>(length & 0xFF)};
  bytes.insert(bytes.end(), preview.begin(), preview.end());
  bytes.insert(bytes.end(), jpeg.begin() + 2, jpeg.end());
  return bytes;
}

TEST(ImageHeader, PreviewInsideTheHeaderIsSkipped) {
  const Buffer preview = encoded(".jpg", 16, 8, CV_8UC3);
  Buffer bytes = with_preview(encoded(".jpg", 256, 128, CV_8UC3), preview);
  EXPECT_EQ(header_of(bytes)->width, 256);
  EXPECT_TRUE(is_complete_image(as_bytes(bytes), ImageFormat::kJpeg));
  bytes.resize(bytes.size() - 100);
  EXPECT_FALSE(is_complete_image(as_bytes(bytes), ImageFormat::kJpeg));
}

TEST(ImageHeader, NonImagesAreRejected) {
  const std::string page = "<!DOCTYPE html><html></html>";
  EXPECT_THROW(header_of({}), Error);
  EXPECT_THROW(header_of(Buffer(page.begin(), page.end())), Error);
  EXPECT_THROW(header_of(encoded(".bmp", 4, 2, CV_8UC3)), Error);
  EXPECT_THROW(header_of({0xFF, 0xD8, 0xFF, 0xD9}), Error) << "ends before it has a size";
  EXPECT_THROW(header_of({0xFF, 0xD8, 0xFF, 0xC0, 0, 4, 8, 0}), Error) << "frame header too short";
  EXPECT_THROW(header_of({0xFF, 0xD8, 0xFF, 0xC0, 0, 8, 8, 0, 0, 0, 4, 3}), Error) << "height 0";
}

TEST(ImageHeader, DamagedBytesAreAnErrorOrAHeaderNeverACrash) {
  std::mt19937 random(11);
  for (const std::string extension : {".jpg", ".png"}) {
    const Buffer whole = encoded(extension, 32, 16, CV_8UC3);
    for (int i = 0; i < 5000; ++i) {
      Buffer damaged = whole;
      for (int change = 0; change < 4; ++change) {
        damaged[random() % damaged.size()] = static_cast<unsigned char>(random());
      }
      try {
        const auto header = header_of(damaged);
        if (!header) continue;
        EXPECT_GE(header->width, 1);
        EXPECT_GE(header->height, 1);
        is_complete_image(as_bytes(damaged), header->format);
      } catch (const Error& e) {
        EXPECT_EQ(std::string(e.what()).rfind("a.jpg: ", 0), 0U);
      }
    }
  }
}

}  // namespace
}  // namespace raywalk
