#include "core/evaluate/metrics/ssim.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "core/evaluate/metrics/ffmpeg_filter.h"
#include "core/evaluate/metrics/luma.h"
#include "core/evaluate/metrics/test_images.h"

namespace raywalk {
namespace {

// ssim.h says why.
constexpr double kTolerance = 1e-6;
constexpr const char* kWithoutSimd = "-cpuflags 0";

double ffmpeg_ssim(const cv::Mat& a, const cv::Mat& b, const std::string& options = "") {
  return ffmpeg_filter_value("ssim", "Y", luma_8bit(a), luma_8bit(b), options);
}

TEST(Ssim, AgreesWithFfmpeg) {
  const cv::Mat image = textured_image({512, 256});
  const cv::Mat dark = adjusted(image, 0.05, 0.0);
  const std::vector<std::pair<cv::Mat, cv::Mat>> pairs = {
      {image, noisy(image, 1.0)},
      {image, noisy(image, 40.0)},
      {image, blurred(image, 2.0)},
      {image, adjusted(image, 0.8, 20.0)},
      {image, adjusted(image, -1.0, 255.0)},
      {image, rolled(image, 7)},
      {dark, noisy(dark, 2.0)},
      {image, flat_image(image.size(), {90, 120, 150})}};
  for (const auto& [a, b] : pairs) EXPECT_NEAR(ssim(a, b), ffmpeg_ssim(a, b), kTolerance);
}

TEST(Ssim, AgreesWithFfmpegAtEverySize) {
  for (const cv::Size size : {cv::Size(8, 8), cv::Size(9, 31), cv::Size(24, 16), cv::Size(50, 11),
                              cv::Size(131, 77), cv::Size(200, 100)}) {
    const cv::Mat a = textured_image(size);
    const cv::Mat b = noisy(a, 20.0);
    EXPECT_NEAR(ssim(a, b), ffmpeg_ssim(a, b, kWithoutSimd), kTolerance) << size;
  }
}

TEST(Ssim, HasTheLuminanceTermOfFfmpegOnFlatImages) {
  // Variances are 0, so that only (2 m_a m_b + C1) / (m_a^2 + m_b^2 + C1) with C1 = 416 / 64^2
  // stays.
  const cv::Size size(64, 32);
  const cv::Mat black = flat_image(size, cv::Scalar::all(0));
  const cv::Mat one = flat_image(size, cv::Scalar::all(1));
  EXPECT_NEAR(ssim(black, one), 416.0 / (4096.0 + 416.0), 1e-12);
  EXPECT_NEAR(ffmpeg_ssim(black, one), 416.0 / (4096.0 + 416.0), kTolerance);
}

TEST(Ssim, IsOneForEqualLumaAndSymmetric) {
  const cv::Mat a = textured_image({128, 64});
  const cv::Mat b = noisy(a, 12.0);
  EXPECT_DOUBLE_EQ(ssim(a, a), 1.0);
  EXPECT_DOUBLE_EQ(ssim(a, b), ssim(b, a));
}

TEST(Ssim, IsNegativeForAnInvertedTexture) {
  cv::Mat checkers(32, 64, CV_8UC3);
  for (int row = 0; row < checkers.rows; ++row) {
    for (int col = 0; col < checkers.cols; ++col) {
      checkers.at<cv::Vec3b>(row, col) = cv::Vec3b::all((row + col) % 2 == 0 ? 80 : 175);
    }
  }
  const double value = ssim(checkers, adjusted(checkers, -1.0, 255.0));
  EXPECT_LT(value, -0.9);
  EXPECT_GE(value, -1.0);
}

TEST(Ssim, FallsAsNoiseGrows) {
  const cv::Mat image = textured_image({256, 128});
  double previous = 1.0;
  for (const double deviation : {2.0, 5.0, 10.0, 20.0, 40.0}) {
    const double value = ssim(image, noisy(image, deviation));
    EXPECT_LT(value, previous) << deviation;
    previous = value;
  }
}

}  // namespace
}  // namespace raywalk
