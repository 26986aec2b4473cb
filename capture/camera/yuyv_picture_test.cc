#include "capture/camera/yuyv_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <vector>

namespace raywalk::capture {
namespace {

constexpr VideoColour kBt601{};
constexpr VideoColour kBt601Full{.full_range = true};
constexpr VideoColour kBt709{.kr = 0.2126, .kb = 0.0722};

VideoFormat format_of(PanoramaSize size, const VideoColour& colour, std::size_t padding = 0) {
  return {.pixels = "YUYV",
          .size = size,
          .bytes_per_line = 2 * static_cast<std::size_t>(size.width) + padding,
          .colour = colour};
}

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

cv::Vec3b first_pixel(std::initializer_list<int> pair, const VideoColour& colour) {
  return bgr_from_yuyv(bytes_of(pair), format_of({2, 1}, colour)).at<cv::Vec3b>(0, 0);
}

void expect_near(const cv::Vec3b& found, const cv::Vec3b& wanted, int tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], tolerance) << "channel " << c;
}

TEST(YuyvPicture, LimitedRangeReachesBlackAndWhiteAt16And235) {
  EXPECT_EQ(first_pixel({16, 128, 16, 128}, kBt601), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(first_pixel({235, 128, 235, 128}, kBt601), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(first_pixel({0, 128, 0, 128}, kBt601Full), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(first_pixel({255, 128, 255, 128}, kBt601Full), cv::Vec3b(255, 255, 255));
}

// The 100 % colour bars of ITU-R BT.601 and BT.709, rounded to bytes.
TEST(YuyvPicture, ColourBarsHaveTheirColours) {
  expect_near(first_pixel({81, 90, 81, 240}, kBt601), {0, 0, 255}, 1);   // red
  expect_near(first_pixel({145, 54, 145, 34}, kBt601), {0, 255, 0}, 1);  // green
  expect_near(first_pixel({41, 240, 41, 110}, kBt601), {255, 0, 0}, 1);  // blue
  expect_near(first_pixel({63, 102, 63, 240}, kBt709), {0, 0, 255}, 1);  // red
  expect_near(first_pixel({173, 42, 173, 26}, kBt709), {0, 255, 0}, 1);  // green
  expect_near(first_pixel({32, 240, 32, 118}, kBt709), {255, 0, 0}, 1);  // blue
}

// Any colour coded by the definition of luma and colour differences is recovered.
TEST(YuyvPicture, AnyColourComesBack) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> level(0.0, 1.0);
  for (const VideoColour& colour : {kBt601, kBt601Full, kBt709}) {
    for (int i = 0; i < 500; ++i) {
      const double r = level(random);
      const double g = level(random);
      const double b = level(random);
      const double y = colour.kr * r + (1.0 - colour.kr - colour.kb) * g + colour.kb * b;
      const double cb = (b - y) / (2.0 * (1.0 - colour.kb));
      const double cr = (r - y) / (2.0 * (1.0 - colour.kr));
      const double chroma = colour.full_range ? 255.0 : 224.0;
      const int luma =
          static_cast<int>(std::lround(colour.full_range ? 255.0 * y : 16.0 + 219.0 * y));
      const auto sample = [&](double c) {
        return std::clamp(static_cast<int>(std::lround(128.0 + chroma * c)), 0, 255);
      };
      const cv::Vec3b found = first_pixel({luma, sample(cb), luma, sample(cr)}, colour);
      // Half a step of each sample, times the largest coefficients 1.16 and 2.1, and rounding.
      expect_near(found,
                  cv::Vec3b(static_cast<uchar>(std::lround(255.0 * b)),
                            static_cast<uchar>(std::lround(255.0 * g)),
                            static_cast<uchar>(std::lround(255.0 * r))),
                  3);
    }
  }
}

TEST(YuyvPicture, PairsShareChromaAndHaveTheirOwnLuma) {
  const cv::Mat bgr =
      bgr_from_yuyv(bytes_of({16, 128, 235, 128, 235, 128, 16, 128}), format_of({4, 1}, kBt601));
  EXPECT_EQ(bgr.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(bgr.at<cv::Vec3b>(0, 1), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(bgr.at<cv::Vec3b>(0, 2), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(bgr.at<cv::Vec3b>(0, 3), cv::Vec3b(0, 0, 0));
}

TEST(YuyvPicture, LinesMayBePaddedTheLastOneNeedNot) {
  const VideoFormat format = format_of({2, 2}, kBt601, 3);
  const auto frame = bytes_of({16, 128, 16, 128, 9, 9, 9, 235, 128, 235, 128});
  EXPECT_EQ(min_yuyv_bytes(format), frame.size());
  const cv::Mat bgr = bgr_from_yuyv(frame, format);
  EXPECT_EQ(bgr.at<cv::Vec3b>(0, 1), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(bgr.at<cv::Vec3b>(1, 0), cv::Vec3b(255, 255, 255));
}

TEST(YuyvPicture, FileDecodesToTheFrame) {
  const VideoFormat format = format_of({32, 16}, kBt601);
  std::vector<std::byte> frame;
  for (int i = 0; i < 16 * 16; ++i) {
    for (const int value : {81, 90, 81, 240}) frame.push_back(static_cast<std::byte>(value));
  }
  const std::string file = jpeg_from_yuyv(frame, format, 95);
  const cv::Mat decoded =
      cv::imdecode(std::vector<unsigned char>(file.begin(), file.end()), cv::IMREAD_COLOR);
  ASSERT_EQ(decoded.size(), cv::Size(32, 16));
  expect_near(decoded.at<cv::Vec3b>(8, 8), {0, 0, 255}, 3);
}

}  // namespace
}  // namespace raywalk::capture
