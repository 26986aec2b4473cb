#include "core/evaluate/metrics/psnr.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/evaluate/metrics/ffmpeg_filter.h"
#include "core/evaluate/metrics/test_images.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A black image and the same with one row at `level`.
cv::Mat with_bright_row(cv::Size size, int row, double level) {
  cv::Mat image = flat_image(size, {0, 0, 0});
  image.row(row).setTo(cv::Scalar::all(level));
  return image;
}

TEST(MeanSquaredError, AveragesPixelsAndChannels) {
  const cv::Mat a = flat_image({4, 2}, {10, 10, 10});
  cv::Mat b = a.clone();
  b.at<cv::Vec3b>(1, 3) = {13, 10, 6};  // 9 + 16 over 8 pixels of 3 channels
  EXPECT_DOUBLE_EQ(mean_squared_error(a, b), 25.0 / 24.0);
  EXPECT_DOUBLE_EQ(mean_squared_error(b, a), 25.0 / 24.0);
}

TEST(MeanSquaredError, TakesTheMaskedPixelsOnly) {
  const cv::Mat a = flat_image({4, 2}, {10, 10, 10});
  cv::Mat b = a.clone();
  b.at<cv::Vec3b>(1, 3) = {13, 10, 6};
  b.at<cv::Vec3b>(0, 0) = {200, 200, 200};
  cv::Mat mask = cv::Mat::zeros(a.size(), CV_8UC1);
  mask.at<std::uint8_t>(1, 3) = 1;
  mask.at<std::uint8_t>(1, 2) = 255;
  EXPECT_DOUBLE_EQ(mean_squared_error(a, b, mask), 25.0 / 6.0);
}

TEST(MeanSquaredError, WorksOnAColumnRange) {
  const cv::Mat a = textured_image({64, 32});
  const cv::Mat b = noisy(a, 10.0);
  const cv::Mat columns_a = a.colRange(5, 12);
  const cv::Mat columns_b = b.colRange(5, 12);
  cv::Mat mask = cv::Mat::zeros(a.size(), CV_8UC1);
  mask.colRange(5, 12).setTo(1);
  EXPECT_GT(mean_squared_error(columns_a, columns_b), 0.0);
  EXPECT_DOUBLE_EQ(mean_squared_error(columns_a, columns_b), mean_squared_error(a, b, mask));
}

TEST(MeanSquaredError, RefusesAMaskThatSelectsNothingOrDoesNotFit) {
  const cv::Mat image = flat_image({4, 2}, {});
  EXPECT_THAT([&] { mean_squared_error(image, image, cv::Mat::zeros(2, 4, CV_8UC1)); },
              ThrowsMessage<Error>(HasSubstr("selects no pixel")));
  EXPECT_THAT([&] { mean_squared_error(image, image, cv::Mat::ones(4, 2, CV_8UC1)); },
              ThrowsMessage<Error>(HasSubstr("mask")));
  EXPECT_THROW(mean_squared_error(image, image, cv::Mat::ones(2, 4, CV_32FC1)), Error);
}

TEST(Psnr, LeavesOutWhatIsMasked) {
  const cv::Mat a = flat_image({64, 32}, {50, 60, 70});
  cv::Mat b = flat_image({64, 32}, {55, 65, 75});
  b.rowRange(20, 32).setTo(cv::Scalar(200, 0, 200));
  cv::Mat mask = cv::Mat::zeros(a.size(), CV_8UC1);
  mask.rowRange(0, 20).setTo(255);
  const double expected_db = 20.0 * std::log10(255.0 / 5.0);
  EXPECT_LT(psnr_db(a, b), expected_db - 10.0);
  EXPECT_NEAR(psnr_db(a, b, mask), expected_db, 1e-12);
  EXPECT_NEAR(ws_psnr_db(a, b, mask), expected_db, 1e-12);
  EXPECT_NEAR(ws_psnr_db(a, b, cv::Mat(a.size(), CV_8UC1, cv::Scalar(1))), ws_psnr_db(a, b), 1e-12);
  EXPECT_THROW(ws_psnr_db(a, b, cv::Mat::zeros(a.size(), CV_8UC1)), Error);
}

TEST(Psnr, HasItsLimits) {
  const cv::Mat image = textured_image({64, 32});
  EXPECT_EQ(psnr_db(image, image), kInfinity);
  EXPECT_EQ(ws_psnr_db(image, image), kInfinity);
  const cv::Mat black = flat_image({64, 32}, {0, 0, 0});
  const cv::Mat white = flat_image({64, 32}, {255, 255, 255});
  EXPECT_NEAR(psnr_db(black, white), 0.0, 1e-12);
  EXPECT_NEAR(ws_psnr_db(black, white), 0.0, 1e-12);
}

TEST(Psnr, OfAMeanSquaredError) {
  EXPECT_EQ(psnr_db(0.0), kInfinity);
  EXPECT_EQ(psnr_db(255.0 * 255.0), 0.0);
  EXPECT_NEAR(psnr_db(1.0), 48.1308, 1e-4);
}

TEST(Psnr, IsTheClosedFormForAUniformError) {
  const cv::Mat a = flat_image({64, 32}, {50, 60, 70});
  const cv::Mat b = flat_image({64, 32}, {55, 65, 75});
  const double expected_db = 20.0 * std::log10(255.0 / 5.0);
  EXPECT_NEAR(psnr_db(a, b), expected_db, 1e-12);
  EXPECT_NEAR(ws_psnr_db(a, b), expected_db, 1e-12);
}

// ffmpeg prints 6 decimals and averages over the planes in double like this function: the
// difference is at most half a unit of the last decimal.
TEST(Psnr, AgreesWithFfmpegOverRgb) {
  constexpr double kTolerance_db = 1e-6;
  const cv::Mat image = textured_image({512, 256});
  const cv::Mat odd = textured_image({131, 77});
  const std::vector<std::pair<cv::Mat, cv::Mat>> pairs = {
      {image, noisy(image, 1.0)},
      {image, noisy(image, 40.0)},
      {image, blurred(image, 2.0)},
      {image, adjusted(image, 0.8, 20.0)},
      {image, rolled(image, 7)},
      {odd, noisy(odd, 5.0)},
      {image, flat_image(image.size(), {90, 120, 150})}};
  for (const auto& [a, b] : pairs) {
    EXPECT_NEAR(psnr_db(a, b), ffmpeg_filter_value("psnr", "average", a, b), kTolerance_db);
  }
}

// An error in one channel only: a metric on luma or on one plane would give another value.
TEST(Psnr, CountsTheChannelsAlikeAsFfmpegDoes) {
  const cv::Mat a = flat_image({64, 32}, {100, 100, 100});
  const double expected_db = 10.0 * std::log10(255.0 * 255.0 / (36.0 / 3.0));
  for (const cv::Scalar& bgr :
       {cv::Scalar(106, 100, 100), cv::Scalar(100, 106, 100), cv::Scalar(100, 100, 106)}) {
    const cv::Mat b = flat_image({64, 32}, bgr);
    EXPECT_NEAR(psnr_db(a, b), expected_db, 1e-12);
    EXPECT_NEAR(ffmpeg_filter_value("psnr", "average", a, b), expected_db, 1e-6);
  }
}

// Row v of H lies at phi = 90 - (v + 0.5) / H 180 degrees, and the weights add up in closed form:
// sum cos(phi) = 1 / sin(pi / (2 H)) (a sum of cosines in arithmetic progression). So an error e in
// row v alone gives WMSE = e^2 cos(phi) sin(pi / (2 H)).
TEST(WsPsnr, IsTheClosedFormForAnErrorInOneRow) {
  constexpr double kError = 40.0;
  for (const int height : {1, 2, 9, 32, 257}) {
    const cv::Size size(2 * height, height);
    const cv::Mat black = flat_image(size, {0, 0, 0});
    for (const int row : {0, height / 3, height - 1}) {
      const double phi = std::numbers::pi * (0.5 - (row + 0.5) / height);
      const double weighted =
          kError * kError * std::cos(phi) * std::sin(std::numbers::pi / (2.0 * height));
      EXPECT_NEAR(ws_psnr_db(black, with_bright_row(size, row, kError)),
                  10.0 * std::log10(255.0 * 255.0 / weighted), 1e-9)
          << "row " << row << " of " << height;
    }
  }
}

TEST(WsPsnr, ForgivesErrorsAtThePolesAndNotAtTheHorizon) {
  const cv::Size size(64, 32);
  const cv::Mat black = flat_image(size, {0, 0, 0});
  const cv::Mat at_pole = with_bright_row(size, 0, 50);
  const cv::Mat at_horizon = with_bright_row(size, 16, 50);
  EXPECT_DOUBLE_EQ(psnr_db(black, at_pole), psnr_db(black, at_horizon));
  EXPECT_GT(ws_psnr_db(black, at_pole), psnr_db(black, at_pole) + 10.0);
  EXPECT_LT(ws_psnr_db(black, at_horizon), psnr_db(black, at_horizon) - 1.0);
}

}  // namespace
}  // namespace raywalk
