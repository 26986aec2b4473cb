#include "simulator/room/thin_structures.h"

#include <gtest/gtest.h>

#include <limits>
#include <opencv2/core.hpp>

namespace raywalk::capture {
namespace {

// 360 columns of one degree; a wall at 3 m.
cv::Mat wall() { return cv::Mat(180, 360, CV_32FC1, cv::Scalar(3.0)); }

TEST(ThinStructuresTest, PostsAreThinAndCabinetsAreNot) {
  cv::Mat map = wall();
  map.colRange(100, 102).rowRange(60, 120).setTo(1.5);  // a post
  map.rowRange(90, 91).colRange(200, 260).setTo(1.5);   // a rail
  map.colRange(20, 60).rowRange(60, 120).setTo(1.5);    // a cabinet
  const cv::Mat thin = thin_structures(map);
  EXPECT_EQ(cv::countNonZero(thin(cv::Rect(99, 60, 4, 60))), 4 * 60) << "with a pixel around";
  EXPECT_EQ(cv::countNonZero(thin(cv::Rect(200, 89, 60, 3))), 3 * 60);
  EXPECT_EQ(cv::countNonZero(thin), 4 * 62 + 3 * 62);
}

TEST(ThinStructuresTest, PostsBeforeTheSkyAndAcrossTheSeamAreFound) {
  cv::Mat map = wall();
  map.rowRange(0, 90).setTo(std::numeric_limits<float>::infinity());
  map.colRange(0, 1).setTo(2.0);
  map.colRange(359, 360).setTo(2.0);
  const cv::Mat thin = thin_structures(map);
  EXPECT_EQ(thin.at<uchar>(40, 0), 255);
  EXPECT_EQ(thin.at<uchar>(130, 359), 255);
  EXPECT_EQ(thin.at<uchar>(40, 5), 0);
}

TEST(ThinStructuresTest, SlopesAreNotThin) {
  cv::Mat map = wall();
  for (int v = 100; v < 180; ++v) map.row(v).setTo(3.0 / (1.0 + 0.05 * (v - 100)));
  EXPECT_EQ(cv::countNonZero(thin_structures(map)), 0);
}

}  // namespace
}  // namespace raywalk::capture
