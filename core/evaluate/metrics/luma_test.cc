#include "core/evaluate/metrics/luma.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/evaluate/metrics/test_images.h"

namespace raywalk {
namespace {

TEST(Luma, WeighsThePrimariesAsBt601) {
  cv::Mat image(1, 4, CV_8UC3);
  image.at<cv::Vec3b>(0, 0) = {255, 0, 0};
  image.at<cv::Vec3b>(0, 1) = {0, 255, 0};
  image.at<cv::Vec3b>(0, 2) = {0, 0, 255};
  image.at<cv::Vec3b>(0, 3) = {255, 255, 255};
  const cv::Mat exact = luma_unrounded(image);
  ASSERT_EQ(exact.type(), CV_64FC1);
  EXPECT_NEAR(exact.at<double>(0, 0), 29.07, 1e-9);
  EXPECT_NEAR(exact.at<double>(0, 1), 149.685, 1e-9);
  EXPECT_NEAR(exact.at<double>(0, 2), 76.245, 1e-9);
  EXPECT_NEAR(exact.at<double>(0, 3), 255.0, 1e-9);
}

TEST(Luma, EightBitIsTheRoundedValue) {
  const cv::Mat image = textured_image({128, 64});
  const cv::Mat rounded = luma_8bit(image);
  ASSERT_EQ(rounded.type(), CV_8UC1);
  cv::Mat exact_levels;
  rounded.convertTo(exact_levels, CV_64F);
  // OpenCV computes the 8-bit form in fixed point, which may decide a tie differently.
  EXPECT_LE(cv::norm(exact_levels, luma_unrounded(image), cv::NORM_INF), 0.5 + 1e-3);
}

TEST(Luma, KeepsGrey) {
  for (int level = 0; level < 256; ++level) {
    const cv::Mat grey = flat_image({1, 1}, cv::Scalar::all(level));
    EXPECT_EQ(luma_8bit(grey).at<std::uint8_t>(0, 0), level);
  }
}

}  // namespace
}  // namespace raywalk
