#include "core/files/jpeg_encoder.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/files/jpeg_decoder.h"

namespace raywalk {
namespace {

TEST(JpegEncoder, KeepsColoursThatChangeFromPixelToPixel) {
  // Halved in resolution, red and blue columns would both become purple.
  cv::Mat columns(32, 64, CV_8UC3);
  for (int v = 0; v < columns.rows; ++v) {
    for (int u = 0; u < columns.cols; ++u) {
      columns.at<cv::Vec3b>(v, u) = u % 2 == 0 ? cv::Vec3b(0, 0, 200) : cv::Vec3b(200, 0, 0);
    }
  }
  const cv::Mat decoded = decode_jpeg(encode_jpeg(columns, 95), JpegColours::kBgr, "columns");
  ASSERT_EQ(decoded.size(), columns.size());
  EXPECT_LT(cv::norm(decoded, columns, cv::NORM_L1) / double(columns.total() * 3), 8.0);
}

TEST(JpegEncoder, SmallerQualityIsFewerBytes) {
  cv::Mat noise(64, 128, CV_8UC3);
  cv::randu(noise, 0, 255);
  EXPECT_LT(encode_jpeg(noise, 50).size(), encode_jpeg(noise, 90).size());
}

TEST(JpegEncoder, RefusesWhatJpegCannotHold) {
  EXPECT_THROW(encode_jpeg({}, 90), Error);
  EXPECT_THROW(encode_jpeg(cv::Mat(4, 4, CV_16UC3), 90), Error);
  EXPECT_THROW(encode_jpeg(cv::Mat(1, 70000, CV_8UC3), 90), Error);
}

}  // namespace
}  // namespace raywalk
