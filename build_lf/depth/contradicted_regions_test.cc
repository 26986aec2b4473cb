#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "build_lf/depth/contradictions.h"

namespace raywalk::build_lf {
namespace {

constexpr GapLimits kLimits{12.0f, 24.0f};

// Gaps of `level` in a rectangle of a transposed panorama, around the seam.
cv::Mat gaps_in(int theta, int phi, int thetas, int phis, float level) {
  cv::Mat gaps = cv::Mat::zeros(256, 128, CV_32FC1);
  for (int t = theta; t < theta + thetas; ++t) {
    for (int p = phi; p < phi + phis; ++p) gaps.at<float>((t + 256) % 256, p) = level;
  }
  return gaps;
}

TEST(ContradictedRegions, AreFoundWithThePixelsMixedWithThem) {
  const cv::Mat regions = contradicted_regions(gaps_in(100, 40, 10, 30, 50.0f), kLimits);
  EXPECT_EQ(cv::boundingRect(regions), cv::Rect(38, 98, 34, 14));
  EXPECT_EQ(cv::countNonZero(regions), 34 * 14);
}

TEST(ContradictedRegions, AreWholeAcrossTheSeam) {
  const cv::Mat regions = contradicted_regions(gaps_in(-3, 40, 6, 8, 50.0f), kLimits);
  EXPECT_EQ(cv::countNonZero(regions), 10 * 12);
  EXPECT_NE(regions.at<uchar>(0, 44), 0);
  EXPECT_NE(regions.at<uchar>(255, 44), 0);
}

TEST(ContradictedRegions, WeakGapsBelongToARegionButMakeNone) {
  EXPECT_EQ(cv::countNonZero(contradicted_regions(gaps_in(100, 40, 10, 30, 20.0f), kLimits)), 0);
  cv::Mat gaps = gaps_in(100, 40, 10, 30, 20.0f);
  gaps(cv::Rect(50, 102, 5, 5)) = 50.0f;
  EXPECT_EQ(cv::countNonZero(contradicted_regions(gaps, kLimits)), 34 * 14);
}

TEST(ContradictedRegions, ThinOnesAndSpecksAreNone) {
  EXPECT_EQ(cv::countNonZero(contradicted_regions(gaps_in(100, 10, 4, 100, 50.0f), kLimits)), 0);
  cv::Mat specks = cv::Mat::zeros(256, 128, CV_32FC1);
  for (int t = 0; t < 256; t += 4) {
    for (int p = 0; p < 128; p += 4) specks.at<float>(t, p) = 100.0f;
  }
  EXPECT_EQ(cv::countNonZero(contradicted_regions(specks, kLimits)), 0);
}

TEST(ContradictedRegions, HolesOfASinglePixelAreClosed) {
  cv::Mat gaps = gaps_in(100, 40, 10, 10, 50.0f);
  gaps.at<float>(105, 45) = 0.0f;
  EXPECT_EQ(cv::countNonZero(contradicted_regions(gaps, kLimits)), 14 * 14);
}

}  // namespace
}  // namespace raywalk::build_lf
