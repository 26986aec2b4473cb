#include "capture/simulated/jpeg_encoder.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

cv::Mat decode(const std::vector<std::byte>& bytes) {
  const auto* first = reinterpret_cast<const unsigned char*>(bytes.data());
  return cv::imdecode(std::vector<unsigned char>(first, first + bytes.size()), cv::IMREAD_COLOR);
}

// Alternating columns of red and blue; chroma subsampling turns them purple.
cv::Mat fine_colors() {
  cv::Mat image(32, 48, CV_8UC3);
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      image.at<cv::Vec3b>(row, column) =
          column % 2 == 0 ? cv::Vec3b(40, 40, 200) : cv::Vec3b(200, 40, 40);
    }
  }
  return image;
}

TEST(JpegEncoderTest, KeepsColorInFullResolution) {
  const cv::Mat image = fine_colors();
  EXPECT_LT(cv::norm(decode(encode_jpeg(image, 95)), image, cv::NORM_INF), 25.0);
  // The rows of a sub-image are not contiguous in memory.
  const cv::Mat part = image(cv::Rect(8, 8, 16, 16));
  EXPECT_LT(cv::norm(decode(encode_jpeg(part, 95)), part, cv::NORM_INF), 25.0);
}

TEST(JpegEncoderTest, QuarterColorMixesNeighbours) {
  const cv::Mat decoded = decode(encode_jpeg(fine_colors(), 95, JpegColour::kQuarter));
  const cv::Vec3b left = decoded.at<cv::Vec3b>(16, 20), right = decoded.at<cv::Vec3b>(16, 21);
  EXPECT_LT(std::abs(left[2] - right[2]), 60) << "160 apart in the picture";
}

TEST(JpegEncoderTest, QualityTradesSize) {
  const cv::Mat image = fine_colors();
  EXPECT_LT(encode_jpeg(image, 20).size(), encode_jpeg(image, 100).size());
}

TEST(JpegEncoderTest, RefusesUnsupportedImages) {
  EXPECT_THROW(encode_jpeg(cv::Mat(4, 4, CV_8UC1), 90), Error);
  EXPECT_THROW(encode_jpeg(cv::Mat(1, 70000, CV_8UC3, cv::Scalar::all(0)), 90), Error);
}

}  // namespace
}  // namespace raywalk::capture
