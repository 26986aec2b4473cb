#include "calibrate/rectify/crossing_overlay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "calibrate/base/test_capture_folder.h"

namespace raywalk::calibrate {
namespace {

// Grey, with stripes over an eighth of the width that starts at column `left`.
cv::Mat panorama_with_stripes(int left) {
  cv::Mat panorama(64, 128, CV_8UC3, cv::Scalar(100, 100, 100));
  for (int u = 0; u < 16; ++u) {
    if (u % 4 < 2) panorama.col((left + u) % 128) = cv::Scalar(200, 200, 200);
  }
  return panorama;
}

TEST(CrossingOverlayTest, WindowHasTheMostTexture) {
  for (const int left : {0, 40, 120}) {
    const HorizonWindow window = most_textured_window(panorama_with_stripes(left));
    EXPECT_EQ(window.width, 32);
    const int into = (left - window.left + 128) % 128;
    EXPECT_LE(into, 16) << left;  // all sixteen columns within the window
    EXPECT_EQ(window.top, (64 - window.height) / 2);
  }
}

TEST(CrossingOverlayTest, PicturesThatAgreeAreGrey) {
  const cv::Mat panorama = panorama_with_stripes(120);
  const HorizonWindow window = most_textured_window(panorama);
  const Overlay same = overlay_of(panorama, panorama, window);
  EXPECT_EQ(same.difference_levels, 0.0);
  std::vector<cv::Mat> channels;
  cv::split(same.picture, channels);
  EXPECT_EQ(cv::norm(channels[0], channels[2], cv::NORM_INF), 0.0);
  const Overlay moved = overlay_of(panorama, panorama_with_stripes(122), window);
  EXPECT_GT(moved.difference_levels, 10.0);
  cv::split(moved.picture, channels);
  EXPECT_EQ(cv::norm(channels[0], channels[2], cv::NORM_INF), 100.0);
}

TEST(CrossingOverlayTest, PairIsTheNearestWithPoses) {
  TestCaptureFolder folder;
  folder.write_cross();
  const CaptureSet set = folder.read();
  const LineCrossing crossing = crossings_of(set).at(0);
  FramePoses poses = nominal_poses(set);
  const auto pair = nearest_pair(set, crossing, poses);
  ASSERT_TRUE(pair);
  EXPECT_EQ(set.frames[static_cast<std::size_t>(pair->along_x)].name, "a1");
  EXPECT_EQ(set.frames[static_cast<std::size_t>(pair->along_z)].name, "b1");
  poses[static_cast<std::size_t>(pair->along_x)].reset();
  const auto next = nearest_pair(set, crossing, poses);
  ASSERT_TRUE(next);
  EXPECT_NE(next->along_x, pair->along_x);
  for (auto& pose : poses) pose.reset();
  EXPECT_FALSE(nearest_pair(set, crossing, poses));
}

// Most texture, and all of the difference, is where a mask hides it.
TEST(CrossingOverlayTest, MaskedPixelsAreNotCompared) {
  cv::Mat first(90, 180, CV_8UC3, cv::Scalar::all(100)), valid(90, 180, CV_8UC1, cv::Scalar(255));
  for (int u = 0; u < 20; ++u) first.col(20 + 2 * u).setTo(cv::Scalar::all(200));
  first.col(130).setTo(cv::Scalar::all(120));
  cv::Mat second = first.clone();
  second.colRange(0, 70).setTo(cv::Scalar::all(0));
  valid.colRange(0, 70).setTo(0);
  const HorizonWindow window = most_textured_window(first, valid);
  EXPECT_TRUE(window.left <= 130 && 130 < window.left + window.width) << window.left;
  const HorizonWindow partly_masked{40, 45, 35, 20};
  EXPECT_EQ(overlay_of(first, second, partly_masked, valid).difference_levels, 0.0);
  EXPECT_GT(overlay_of(first, second, partly_masked).difference_levels, 50.0);
  valid.setTo(0);
  EXPECT_TRUE(std::isnan(overlay_of(first, second, window, valid).difference_levels));
}

}  // namespace
}  // namespace raywalk::calibrate
