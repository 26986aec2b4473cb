#include "core/files/jpeg_decoder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/jpeg_errors.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Bytes = std::vector<unsigned char>;

// Smooth, with some texture, as photographs are.
cv::Mat photograph(int width, int height, int channels = 3) {
  cv::Mat picture(height, width, CV_8UC(channels));
  cv::theRNG().state = 5;
  cv::randu(picture, cv::Scalar::all(0), cv::Scalar::all(40));
  for (int v = 0; v < height; ++v) {
    for (int i = 0; i < width * channels; ++i) {
      picture.ptr(v)[i] = static_cast<uchar>(picture.ptr(v)[i] + (3 * v + i / channels) % 200);
    }
  }
  return picture;
}

Bytes encoded(const cv::Mat& picture, const std::vector<int>& parameters = {}) {
  Bytes bytes;
  cv::imencode(".jpg", picture, bytes, parameters);
  return bytes;
}

// A four-channel picture as CMYK, which OpenCV cannot write.
Bytes encoded_cmyk(const cv::Mat& picture) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&encoder);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&encoder, &bytes, &size);
  encoder.image_width = static_cast<JDIMENSION>(picture.cols);
  encoder.image_height = static_cast<JDIMENSION>(picture.rows);
  encoder.input_components = 4;
  encoder.in_color_space = JCS_CMYK;
  jpeg_set_defaults(&encoder);
  jpeg_start_compress(&encoder, TRUE);
  for (int v = 0; v < picture.rows; ++v) {
    auto* row = const_cast<unsigned char*>(picture.ptr(v));
    jpeg_write_scanlines(&encoder, &row, 1);
  }
  jpeg_finish_compress(&encoder);
  jpeg_destroy_compress(&encoder);
  Bytes result(bytes, bytes + size);
  std::free(bytes);
  return result;
}

cv::Mat decoded(const Bytes& bytes, JpegColours colours = JpegColours::kBgr) {
  return decode_jpeg(std::as_bytes(std::span(bytes)), colours, "a.jpg");
}

std::string decoding_error(const Bytes& bytes) {
  return error_of([&] { decoded(bytes); });
}

// Where the entropy-coded data of the first scan begin: after the segment of marker DA.
std::size_t scan_of(const Bytes& bytes) {
  for (std::size_t i = 2; i + 3 < bytes.size();) {
    const std::size_t length = std::size_t{bytes[i + 2]} * 256 + bytes[i + 3];
    if (bytes[i + 1] == 0xDA) return i + 2 + length;
    i += 2 + length;
  }
  ADD_FAILURE() << "no scan";
  return bytes.size();
}

TEST(DecodeJpeg, GivesThePixelsThatOpenCvGives) {
  const cv::Mat colour = photograph(70, 35), grey = photograph(70, 35, 1);
  const std::vector<std::pair<const char*, Bytes>> files = {
      {"colour", encoded(colour)},
      {"progressive", encoded(colour, {cv::IMWRITE_JPEG_PROGRESSIVE, 1})},
      {"with restart markers", encoded(colour, {cv::IMWRITE_JPEG_RST_INTERVAL, 4})},
      {"of low quality", encoded(colour, {cv::IMWRITE_JPEG_QUALITY, 10})},
      {"grey", encoded(grey)},
      {"CMYK", encoded_cmyk(photograph(70, 35, 4))}};
  for (const auto& [kind, bytes] : files) {
    const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    ASSERT_FALSE(expected.empty()) << kind;
    EXPECT_EQ(cv::norm(decoded(bytes), expected, cv::NORM_INF), 0.0) << kind;
    EXPECT_NO_THROW(require_intact_jpeg(std::as_bytes(std::span(bytes)), "a.jpg")) << kind;
  }
  for (const Bytes& bytes : {encoded(colour), encoded(grey)}) {
    EXPECT_EQ(cv::norm(decoded(bytes, JpegColours::kGrey),
                       cv::imdecode(bytes, cv::IMREAD_GRAYSCALE), cv::NORM_INF),
              0.0);
  }
}

TEST(DecodeJpeg, NamesTheDamageAndPrintsNothing) {
  Bytes bytes = encoded(photograph(128, 64));
  const std::size_t middle = (scan_of(bytes) + bytes.size()) / 2;
  bytes[middle] ^= 0x5A;
  bytes[middle + 1] ^= 0x3C;
  testing::internal::CaptureStderr();
  EXPECT_THAT(decoding_error(bytes), AllOf(HasSubstr("a.jpg: damaged, cannot be decoded ("),
                                           HasSubstr("copy or capture it again")));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(DecodeJpeg, FindsEveryTruncation) {
  for (const int progressive : {0, 1}) {
    const Bytes whole = encoded(photograph(64, 32), {cv::IMWRITE_JPEG_PROGRESSIVE, progressive});
    for (std::size_t length = 1; length + 2 < whole.size(); length += 7) {
      Bytes bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_THAT(decoding_error(bytes), HasSubstr("a.jpg: damaged")) << length;
      if (progressive == 1) continue;  // fewer scans are a coarser picture
      bytes.insert(bytes.end(), {0xFF, 0xD9});
      EXPECT_THAT(decoding_error(bytes), HasSubstr("a.jpg: damaged")) << length;
    }
  }
}

TEST(DecodeJpeg, FindsBytesThatDoNotBelong) {
  const Bytes whole = encoded(photograph(64, 32));
  Bytes before_end = whole;
  before_end.insert(before_end.end() - 2, {1, 2, 3});
  EXPECT_THAT(decoding_error(before_end), HasSubstr("extraneous"));
  Bytes in_header = whole;
  in_header.insert(in_header.begin() + 2, {1, 2, 3});
  EXPECT_THAT(decoding_error(in_header), HasSubstr("extraneous"));
  Bytes after_end = whole;  // where cameras keep previews
  after_end.insert(after_end.end(), {1, 2, 3});
  EXPECT_EQ(cv::norm(decoded(after_end), decoded(whole), cv::NORM_INF), 0.0);
}

// OpenCV's decoder, which prints libjpeg's warnings and goes on.
struct OpenCvResult {
  cv::Mat picture;
  std::string warnings;
};

OpenCvResult decoded_by_opencv(const Bytes& bytes) {
  OpenCvResult result;
  testing::internal::CaptureStderr();
  result.picture = cv::imdecode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  result.warnings = testing::internal::GetCapturedStderr();
  return result;
}

// JPEG has no checksums, so some flips give another picture and show by nothing; all with a warning
// are errors.
TEST(DecodeJpeg, FlippedBytesWithAWarningAreErrors) {
  const Bytes whole = encoded(photograph(128, 64));
  int found = 0;
  for (std::size_t at = scan_of(whole); at + 2 < whole.size(); at += 19) {
    for (const unsigned char mask : {0x10, 0xFF}) {
      Bytes bytes = whole;
      bytes[at] ^= mask;
      const OpenCvResult expected = decoded_by_opencv(bytes);
      const std::string error = decoding_error(bytes);
      if (!expected.warnings.empty()) {
        EXPECT_NE(error, "no error") << at;
      }
      EXPECT_EQ(error_of([&] { require_intact_jpeg(std::as_bytes(std::span(bytes)), "a.jpg"); }),
                error)
          << at;
      if (error == "no error") {
        EXPECT_EQ(cv::norm(decoded(bytes), expected.picture, cv::NORM_INF), 0.0) << at;
      } else {
        EXPECT_THAT(error, HasSubstr("a.jpg: damaged"));
        ++found;
      }
    }
  }
  EXPECT_GT(found, 100);
}

}  // namespace
}  // namespace raywalk
