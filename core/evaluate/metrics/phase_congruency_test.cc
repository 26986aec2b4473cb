#include "core/evaluate/metrics/phase_congruency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/evaluate/metrics/luma.h"
#include "core/evaluate/metrics/test_images.h"

namespace raywalk {
namespace {

constexpr int kStep = 64;

// 0 left of column 64 and from column 192 on, `height` between. The steps pass through the middle
// of a pixel (which has half the height), where all odd-symmetric components peak together.
cv::Mat step_image(double height, double base = 0.0) {
  cv::Mat image(128, 256, CV_64FC1, cv::Scalar(base));
  image.colRange(kStep, 193).setTo(base + height);
  image.col(kStep).setTo(base + 0.5 * height);
  image.col(192).setTo(base + 0.5 * height);
  return image;
}

double max_difference(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF); }

TEST(PhaseCongruency, IsNearOneAtAnIdealStepWhateverItsHeight) {
  const PhaseCongruency congruency(cv::Size(256, 128));
  for (const double height : {1.0, 20.0, 255.0}) {
    const cv::Mat result = congruency(step_image(height));
    for (const int row : {0, 63, 127}) EXPECT_GT(result.at<double>(row, kStep), 0.97) << height;
  }
}

TEST(PhaseCongruency, DoesNotPreferRowsOrColumns) {
  // Of odd size: an even one has a bin at the Nyquist frequency, which belongs to no direction.
  const cv::Mat image = luma_unrounded(textured_image({75, 75}));
  const PhaseCongruency congruency(image.size());
  EXPECT_LT(max_difference(congruency(image.t()), congruency(image).t()), 1e-9);
}

TEST(PhaseCongruency, IsLowAwayFromAStepInSlightNoise) {
  const cv::Mat step = step_image(100.0);
  cv::Mat noise(step.size(), CV_64FC1);
  cv::RNG(5).fill(noise, cv::RNG::NORMAL, 0.0, 4.0);
  const cv::Mat result = PhaseCongruency(step.size())(step + noise);
  EXPECT_GT(cv::mean(result.col(kStep))[0], 0.9);
  EXPECT_LT(cv::mean(result.colRange(104, 152))[0], 0.1);
}

TEST(PhaseCongruency, IsOneAtALine) {
  cv::Mat line = cv::Mat::zeros(128, 256, CV_64FC1);
  line.col(100).setTo(200.0);
  EXPECT_GT(PhaseCongruency(line.size())(line).at<double>(64, 100), 0.97);
}

TEST(PhaseCongruency, IsZeroOnFlatImages) {
  for (const cv::Size size : {cv::Size(8, 8), cv::Size(31, 17), cv::Size(256, 128)}) {
    for (const double level : {0.0, 0.3, 127.0, 255.0}) {
      const cv::Mat result = PhaseCongruency(size)(cv::Mat(size, CV_64FC1, cv::Scalar(level)));
      EXPECT_LT(cv::norm(result, cv::NORM_INF), 1e-8) << size << " at " << level;
    }
  }
}

TEST(PhaseCongruency, DoesNotSeeBrightnessOrContrast) {
  const PhaseCongruency congruency(cv::Size(256, 128));
  const cv::Mat image = luma_unrounded(textured_image({256, 128}));
  const cv::Mat expected = congruency(image);
  EXPECT_GT(cv::norm(expected, cv::NORM_INF), 0.5);
  EXPECT_LT(max_difference(congruency(image + 40.0), expected), 1e-9);
  // Only epsilon (1e-4 levels) depends on scale.
  EXPECT_LT(max_difference(congruency(0.5 * image), expected), 1e-3);
}

TEST(PhaseCongruency, SuppressesNoise) {
  cv::Mat noise(128, 256, CV_64FC1);
  cv::RNG(3).fill(noise, cv::RNG::NORMAL, 128.0, 10.0);
  // A clean step reaches 0.97; noise above its own threshold stays far below.
  EXPECT_LT(cv::mean(PhaseCongruency(noise.size())(noise))[0], 0.05);
}

TEST(PhaseCongruency, MovesAndMirrorsWithTheImage) {
  const cv::Mat image = luma_unrounded(textured_image({120, 75}));
  const PhaseCongruency congruency(image.size());
  const cv::Mat expected = congruency(image);
  EXPECT_LT(max_difference(congruency(rolled(image, 37)), rolled(expected, 37)), 1e-9);
  cv::Mat turned;
  cv::Mat expected_turned;
  cv::rotate(image, turned, cv::ROTATE_180);
  cv::rotate(expected, expected_turned, cv::ROTATE_180);
  EXPECT_LT(max_difference(congruency(turned), expected_turned), 1e-9);
}

TEST(PhaseCongruency, StaysWithinItsRange) {
  for (const cv::Size size :
       {cv::Size(8, 8), cv::Size(9, 8), cv::Size(64, 33), cv::Size(101, 53)}) {
    const cv::Mat image = luma_unrounded(noisy(textured_image(size), 25.0));
    const cv::Mat result = PhaseCongruency(size)(image);
    EXPECT_TRUE(cv::checkRange(result, true, nullptr, 0.0, 1.0)) << size;
  }
}

TEST(PhaseCongruency, RefusesAnotherSizeOrType) {
  const PhaseCongruency congruency(cv::Size(16, 8));
  EXPECT_THROW(congruency(cv::Mat::zeros(16, 8, CV_64FC1)), Error);
  EXPECT_THROW(congruency(cv::Mat::zeros(8, 16, CV_8UC1)), Error);
}

}  // namespace
}  // namespace raywalk
