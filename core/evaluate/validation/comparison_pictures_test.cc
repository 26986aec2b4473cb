#include "core/evaluate/validation/comparison_pictures.h"

#include <gtest/gtest.h>

namespace raywalk {
namespace {

cv::Mat grey(int level, cv::Size size = {8, 4}) {
  return cv::Mat(size, CV_8UC3, cv::Scalar::all(level));
}
cv::Vec3b first(const cv::Mat& image) { return image.at<cv::Vec3b>(0, 0); }

TEST(ComparisonPictures, ErrorIsBlackWhereBothAgreeAndSaturates) {
  EXPECT_EQ(first(error_of(grey(90), grey(90))), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(first(error_of(grey(90), grey(80))), cv::Vec3b(40, 40, 40));
  EXPECT_EQ(first(error_of(grey(80), grey(90))), cv::Vec3b(40, 40, 40));
  EXPECT_EQ(first(error_of(grey(0), grey(200))), cv::Vec3b(255, 255, 255));
}

TEST(ComparisonPictures, ShrinksButNeverEnlarges) {
  EXPECT_EQ(shrunk_to(grey(1, {100, 50}), 40).size(), cv::Size(40, 20));
  EXPECT_EQ(shrunk_to(grey(1, {30, 15}), 40).size(), cv::Size(30, 15));
}

}  // namespace
}  // namespace raywalk
