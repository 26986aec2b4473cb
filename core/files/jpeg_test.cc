#include "core/files/jpeg.h"

#include <gmock/gmock.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/files/test_support.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using Bytes = std::vector<unsigned char>;

// Smooth, with some texture, as photographs are.
cv::Mat photograph(int width, int height, int channels = 3) {
  cv::Mat image(height, width, CV_8UC(channels));
  cv::theRNG().state = 5;
  cv::randu(image, cv::Scalar::all(0), cv::Scalar::all(40));
  for (int v = 0; v < height; ++v) {
    for (int i = 0; i < width * channels; ++i) {
      image.ptr(v)[i] = static_cast<uchar>(image.ptr(v)[i] + (3 * v + i / channels) % 200);
    }
  }
  return image;
}

Bytes encoded(const cv::Mat& image, const std::vector<int>& parameters = {}) {
  Bytes bytes;
  cv::imencode(".jpg", image, bytes, parameters);
  return bytes;
}

cv::Mat decoded(const Bytes& bytes, int type = CV_8UC3) {
  return decode_jpeg(std::as_bytes(std::span(bytes)), type, "a.jpg");
}

std::string decoding_error(const Bytes& bytes) {
  return error_of([&] { decoded(bytes); });
}

std::string quick_error(const Bytes& bytes) {
  return error_of([&] { require_intact_jpeg(std::as_bytes(std::span(bytes)), "a.jpg"); });
}

TEST(DecodeJpeg, GivesThePixelsThatOpenCvGives) {
  const cv::Mat colour = photograph(70, 35), grey = photograph(70, 35, 1);
  const std::vector<std::pair<const char*, Bytes>> files = {
      {"colour", encoded(colour)},
      {"progressive", encoded(colour, {cv::IMWRITE_JPEG_PROGRESSIVE, 1})},
      {"with restart markers", encoded(colour, {cv::IMWRITE_JPEG_RST_INTERVAL, 4})},
      {"of low quality", encoded(colour, {cv::IMWRITE_JPEG_QUALITY, 10})},
      {"grey", encoded(grey)}};
  for (const auto& [kind, bytes] : files) {
    const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    ASSERT_FALSE(expected.empty()) << kind;
    EXPECT_EQ(cv::norm(decoded(bytes), expected, cv::NORM_INF), 0.0) << kind;
    EXPECT_EQ(quick_error(bytes), "no error") << kind;
  }
  for (const Bytes& bytes : {encoded(colour), encoded(grey)}) {
    const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
    EXPECT_EQ(cv::norm(decoded(bytes, CV_8UC1), expected, cv::NORM_INF), 0.0);
  }
}

TEST(DecodeJpeg, FindsEveryTruncation) {
  testing::internal::CaptureStderr();
  for (const int progressive : {0, 1}) {
    const Bytes whole = encoded(photograph(64, 32), {cv::IMWRITE_JPEG_PROGRESSIVE, progressive});
    for (std::size_t length = 1; length + 2 < whole.size(); length += 7) {
      Bytes bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
      const std::string error = decoding_error(bytes);
      EXPECT_THAT(error, StartsWith("a.jpg: the image is damaged or cut short (")) << length;
      EXPECT_EQ(quick_error(bytes), error) << length;
      if (progressive == 1) continue;  // fewer scans are a coarser image
      bytes.insert(bytes.end(), {0xFF, 0xD9});
      EXPECT_THAT(decoding_error(bytes), StartsWith("a.jpg: the image is damaged")) << length;
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(DecodeJpeg, StrayBytesAreNoDamage) {
  const Bytes whole = encoded(photograph(64, 32));
  Bytes stray = whole;
  stray.insert(stray.begin() + 2, {1, 2, 3});
  stray.insert(stray.end() - 2, {1, 2, 3});
  stray.insert(stray.end(), {1, 2, 3});  // where cameras keep previews
  EXPECT_EQ(cv::norm(decoded(stray), decoded(whole), cv::NORM_INF), 0.0);
  EXPECT_EQ(quick_error(stray), "no error");
  // They do not hide that the rest is missing.
  stray.resize(stray.size() / 2);
  EXPECT_THAT(decoding_error(stray), HasSubstr("cut short"));
  EXPECT_THAT(quick_error(stray), HasSubstr("cut short"));
}

// JPEG has no checksums, so flips may give another image and show by nothing.
TEST(DecodeJpeg, FlippedBytesAreAnErrorOrAnImageNeverACrash) {
  const Bytes whole = encoded(photograph(128, 64));
  int found = 0;
  for (std::size_t at = 2; at < whole.size(); at += at < 640 ? 1 : 19) {
    for (const unsigned char mask : {0x10, 0xFF}) {
      Bytes bytes = whole;
      bytes[at] ^= mask;
      const std::string error = decoding_error(bytes);
      if (error == "no error") continue;
      EXPECT_THAT(error, StartsWith("a.jpg: ")) << at;
      ++found;
    }
  }
  EXPECT_GT(found, 100);
}

TEST(DecodeJpeg, ASizeThatNobodyHasIsRefusedBeforeItIsAllocated) {
  // Frame header: FF C0, length 17, 8 bits, height, width: 65534 x 65534.
  Bytes bytes = encoded(photograph(64, 32));
  const Bytes frame = {0xFF, 0xC0, 0, 0x11, 8};
  const auto at = std::search(bytes.begin(), bytes.end(), frame.begin(), frame.end());
  ASSERT_NE(at, bytes.end());
  std::fill(at + 5, at + 9, 0xFE);
  EXPECT_THAT(decoding_error(bytes), HasSubstr("65278x65278 is too large"));
  EXPECT_EQ(quick_error(bytes), decoding_error(bytes));
}

TEST(EncodeJpeg, KeepsOrHalvesTheResolutionOfColours) {
  // Red and blue columns; halved in resolution, both become purple.
  cv::Mat columns(32, 64, CV_8UC3);
  for (int u = 0; u < columns.cols; ++u) {
    columns.col(u).setTo(u % 2 == 0 ? cv::Scalar(0, 0, 200) : cv::Scalar(200, 0, 0));
  }
  const auto mean_error = [](const cv::Mat& image, JpegSampling sampling) {
    const cv::Mat back = decode_jpeg(encode_jpeg(image, 95, sampling), CV_8UC3, "columns");
    return cv::norm(back, image, cv::NORM_L1) / static_cast<double>(image.total() * 3);
  };
  EXPECT_LT(mean_error(columns, JpegSampling::kFull), 8.0);
  EXPECT_GT(mean_error(columns, JpegSampling::kQuarter), 30.0);
  // Rows need not follow each other in memory.
  EXPECT_LT(mean_error(columns(cv::Rect(3, 5, 40, 20)), JpegSampling::kFull), 8.0);
}

TEST(EncodeJpeg, RefusesWhatJpegCannotHold) {
  EXPECT_THROW(encode_jpeg({}, 90), Error);
  EXPECT_THROW(encode_jpeg(cv::Mat(4, 4, CV_16UC3), 90), Error);
  EXPECT_THROW(encode_jpeg(cv::Mat(1, 70000, CV_8UC3), 90), Error);
}

}  // namespace
}  // namespace raywalk
