#include "build_lf/quality/colour_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace raywalk::build_lf {
namespace {

// Patches of varying brightness in three colours, shifted by `shift_px` rows, with noise.
ComparedPicture picture_of(double exposure, unsigned noise_seed, double shift_px = 0.0) {
  std::mt19937 random(noise_seed);
  std::normal_distribution<double> noise(0.0, 0.5);
  cv::Mat picture(kComparisonWidth, kComparisonWidth / 2, CV_8UC3);
  for (int u = 0; u < picture.rows; ++u) {
    for (int v = 0; v < picture.cols; ++v) {
      const double patch =
          0.2 + 0.15 * std::sin(16.0 * 2.0 * M_PI * (u - shift_px) / 256.0) * std::cos(0.27 * v);
      for (int c = 0; c < 3; ++c) {
        const double light = patch * (1.0 + 0.2 * c) * exposure;
        picture.at<cv::Vec3b>(u, v)[c] = cv::saturate_cast<uchar>(255.0 * light + noise(random));
      }
    }
  }
  return {.colours = picture};
}

// Also for ratios far below one level, which must not be lost to rounding.
TEST(ColourComparisonTest, RatioIsThatOfTheLevels) {
  for (const double exposure : {0.7, 0.99, 1.002, 1.0, 1.3}) {
    const ColourComparison compared = compare_colours(picture_of(1.0, 1), picture_of(exposure, 2));
    ASSERT_TRUE(compared.comparable);
    for (const double log_ratio : compared.log_ratio) {
      EXPECT_NEAR(log_ratio, std::log(exposure), 0.0025) << exposure;
    }
  }
}

TEST(ColourComparisonTest, MotionIsCompensated) {
  const ColourComparison compared = compare_colours(picture_of(1.0, 1), picture_of(1.1, 2, 2.0));
  ASSERT_TRUE(compared.comparable);
  EXPECT_NEAR(compared.log_ratio[1], std::log(1.1), 0.01);
  EXPECT_LT(compared.unexplained_change, 0.5 * compared.change);
}

TEST(ColourComparisonTest, MaskedAndClippedPixelsAreIgnored) {
  const ComparedPicture first = picture_of(1.0, 1);
  ComparedPicture second = picture_of(1.2, 2);
  // Two thirds of the picture, enough to change a median.
  second.colours.colRange(40, 128) = cv::Scalar(140, 140, 140);
  const auto log_ratio = [&] { return compare_colours(first, second).log_ratio[0]; };
  EXPECT_GT(std::abs(log_ratio() - std::log(1.2)), 0.05);
  second.valid = cv::Mat(256, 128, CV_8UC1, cv::Scalar(255));
  second.valid.colRange(30, 128) = cv::Scalar(0);
  EXPECT_NEAR(log_ratio(), std::log(1.2), 0.005);
  second.valid = cv::Scalar(0);
  EXPECT_FALSE(compare_colours(first, second).comparable);
  second.valid.release();
  second.colours = cv::Scalar(255, 255, 255);
  EXPECT_FALSE(compare_colours(first, second).comparable);
}

}  // namespace
}  // namespace raywalk::build_lf
