#include "core/view/unknown_pixels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

constexpr int kColumns = 96;
constexpr int kRows = 48;

// A picture whose values are not known in a rectangle, and absurd there.
struct HoledPicture {
  cv::Mat values = cv::Mat(kRows, kColumns, CV_32FC1);
  cv::Mat truth = cv::Mat(kRows, kColumns, CV_32FC1);
  cv::Mat weights = cv::Mat(kRows, kColumns, CV_32FC1, cv::Scalar(1.0));

  template <typename ValueAt>
  HoledPicture(const ValueAt& value_at, const cv::Rect& hole) {
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) truth.at<float>(y, x) = static_cast<float>(value_at(x, y));
    }
    truth.copyTo(values);
    values(hole) = 1e6;
    weights(hole) = 0.0;
  }
  double largest_error() const { return cv::norm(values, truth, cv::NORM_INF); }
};

TEST(UnknownPixels, AConstantPictureStaysConstant) {
  for (const Seam seam : {Seam::kOpen, Seam::kJoined}) {
    HoledPicture picture([](int, int) { return 7.5; }, {20, 5, 40, 43});
    EXPECT_TRUE(fill_unknown(picture.values, picture.weights, seam));
    EXPECT_LT(picture.largest_error(), 1e-4);
  }
}

TEST(UnknownPixels, ARampIsContinued) {
  HoledPicture picture([](int x, int y) { return 2.0 * x + y; }, {30, 12, 24, 20});
  EXPECT_TRUE(fill_unknown(picture.values, picture.weights, Seam::kOpen));
  EXPECT_LT(picture.largest_error(), 4.0);  // of 66 across the hole
}

TEST(UnknownPixels, KnownPixelsAreKept) {
  HoledPicture picture([](int x, int y) { return (13 * x + 7 * y) % 31; }, {30, 12, 24, 20});
  EXPECT_TRUE(fill_unknown(picture.values, picture.weights, Seam::kOpen));
  cv::Mat known;
  picture.weights.convertTo(known, CV_8U);
  EXPECT_EQ(cv::norm(picture.values, picture.truth, cv::NORM_INF, known), 0.0);
}

TEST(UnknownPixels, APictureWithoutAKnownPixelIsLeftAsItIs) {
  HoledPicture picture([](int x, int) { return x; }, {0, 0, kColumns, kRows});
  picture.truth.copyTo(picture.values);
  EXPECT_FALSE(fill_unknown(picture.values, picture.weights, Seam::kJoined));
  EXPECT_EQ(picture.largest_error(), 0.0);
}

TEST(UnknownPixels, OneKnownPixelFillsAll) {
  HoledPicture picture([](int, int) { return 3.0; }, {0, 0, kColumns, kRows});
  picture.values.at<float>(31, 77) = 3.0f;
  picture.weights.at<float>(31, 77) = 1.0f;
  EXPECT_TRUE(fill_unknown(picture.values, picture.weights, Seam::kOpen));
  EXPECT_LT(picture.largest_error(), 1e-5);
}

// Left of the hole is 0, right of it 100: with the seam joined, a hole across it goes smoothly from
// one to the other.
TEST(UnknownPixels, AHoleAcrossTheSeamIsFilledFromBothOfItsSides) {
  HoledPicture picture([](int x, int) { return x < kColumns / 2 ? 0.0 : 100.0; },
                       {0, 0, 12, kRows});
  picture.values.colRange(kColumns - 12, kColumns) = 1e6;
  picture.weights.colRange(kColumns - 12, kColumns) = 0.0;
  EXPECT_TRUE(fill_unknown(picture.values, picture.weights, Seam::kJoined));
  const auto at = [&](int x) {
    return picture.values.at<float>(kRows / 2, (x + kColumns) % kColumns);
  };
  for (int x = -12; x < 12; ++x) EXPECT_LT(std::fabs(at(x) - at(x - 1)), 100.0 / 8.0) << x;
  EXPECT_NEAR(0.5 * (at(-1) + at(0)), 50.0, 3.0);
}

TEST(UnknownPixels, AnOpenBorderDoesNotReachTheOtherSide) {
  HoledPicture picture([](int x, int) { return x < kColumns / 2 ? 0.0 : 100.0; },
                       {0, 0, 12, kRows});
  EXPECT_TRUE(fill_unknown(picture.values, picture.weights, Seam::kOpen));
  EXPECT_LT(picture.largest_error(), 1e-3);
}

TEST(UnknownPixels, WeightsBetweenMixWithTheSurroundings) {
  HoledPicture picture([](int, int) { return 10.0; }, {40, 20, 1, 1});
  picture.values.at<float>(20, 40) = 50.0f;
  picture.weights.at<float>(20, 40) = 0.25f;
  EXPECT_TRUE(fill_unknown(picture.values, picture.weights, Seam::kOpen));
  EXPECT_NEAR(picture.values.at<float>(20, 40), 0.25 * 50.0 + 0.75 * 10.0, 1e-4);
}

TEST(UnknownPixels, ChannelsAreFilledAlike) {
  HoledPicture one([](int x, int y) { return x * y; }, {10, 10, 30, 20});
  cv::Mat three;
  cv::merge(std::vector<cv::Mat>{one.values, 2.0 * one.values, 3.0 * one.values}, three);
  EXPECT_TRUE(fill_unknown(one.values, one.weights, Seam::kJoined));
  EXPECT_TRUE(fill_unknown(three, one.weights, Seam::kJoined));
  std::vector<cv::Mat> channels;
  cv::split(three, channels);
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT(cv::norm(channels[static_cast<size_t>(c)], (c + 1.0) * one.values, cv::NORM_INF),
              0.1);
  }
}

// All columns of a panorama meet at a pole: what is filled there must not depend on the column.
TEST(UnknownPixels, APoleHasOneValue) {
  HoledPicture picture([](int x, int) { return x % 24 < 12 ? 0.0 : 100.0; },
                       {0, kRows - 16, kColumns, 16});
  std::vector<float> cosines;
  for (int row = 0; row < kRows; ++row) {
    cosines.push_back(static_cast<float>(
        std::cos(angles_from_pixel({0.0, double(row)}, {kColumns, kRows}).phi_rad)));
  }
  EXPECT_TRUE(fill_unknown(picture.values, picture.weights, Seam::kJoined, cosines));
  double least = 0.0, most = 0.0;
  cv::minMaxLoc(picture.values.row(kRows - 1), &least, &most);
  EXPECT_NEAR(least, 50.0, 5.0);
  EXPECT_NEAR(most, 50.0, 5.0);
}

}  // namespace
}  // namespace raywalk
