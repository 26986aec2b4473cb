#include "build_lf/depth/station_colours.h"

#include <gtest/gtest.h>

#include "build_lf/depth/depth_test_room.h"

namespace raywalk::build_lf {
namespace {

TEST(StationColoursTest, AreARangeWhereAChannelIsDarkOrClipped) {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.spacing_m = 0.5;
  const DepthTestRoom room(spec, [](StationIndex, cv::Mat* frame) {
    frame->setTo(cv::Scalar(100, 100, 100));
    frame->at<cv::Vec3b>(10, 20) = {255, 100, 2};  // blue, green, red
  });
  const GainField darker{.whole = {0.5f, 0.5f, 0.5f}};
  const StationColours colours = station_colours(room.room(), {0, 1}, {128, 64}, darker);
  const cv::Mat ranges = ranges_of(colours);
  const ColourRange clipped = range_at(ranges, pixel_index(20, 10, {128, 64}));
  EXPECT_EQ(clipped.least, cv::Vec3b(0, 50, 128));
  EXPECT_EQ(clipped.most, cv::Vec3b(1, 50, 255));
  const ColourRange plain = range_at(ranges, pixel_index(21, 10, {128, 64}));
  EXPECT_EQ(plain.least, cv::Vec3b(50, 50, 50));
  EXPECT_EQ(plain.most, plain.least);
  EXPECT_EQ(colours.shown.at<cv::Vec3b>(21, 10), plain.least);
}

TEST(StationColoursTest, HaveNoGapWhereRangesOverlap) {
  const ColourRange grey{{90, 90, 90}, {110, 110, 110}};
  EXPECT_EQ(gap_between(grey, {{100, 90, 80}, {255, 95, 90}}), 0);
  EXPECT_EQ(gap_between(grey, {{100, 90, 0}, {120, 95, 70}}), 20);
  EXPECT_EQ(gap_between({{100, 90, 0}, {120, 95, 70}}, grey), 20);
}

TEST(StationColoursTest, SampledRangesHoldBothSidesOfAnEdgeAndNothingOfAMask) {
  cv::Mat picture(32, 16, CV_8UC3, cv::Scalar(50, 50, 50));
  picture.rowRange(16, 32).setTo(cv::Scalar(150, 150, 150));
  cv::Mat valid(32, 16, CV_8UC1, cv::Scalar(255));
  valid.at<std::uint8_t>(20, 8) = 0;
  const cv::Mat ranges = sampled_ranges({picture, picture, picture}, valid);
  const auto at = [&](int theta, int phi) { return *ranges.ptr<ColourRange>(theta, phi); };
  EXPECT_EQ(ranges.rows, 64);
  EXPECT_EQ(gaps_between(at(16, 16), {{50, 50, 50}, {50, 50, 50}}), 0);
  EXPECT_EQ(gaps_between(at(16, 16), {{150, 50, 50}, {150, 50, 50}}), 100);
  EXPECT_LT(gaps_between(at(31, 16), {{90, 90, 90}, {90, 90, 90}}), 15);
  EXPECT_GT(gaps_between(at(28, 16), {{90, 90, 90}, {90, 90, 90}}), 100);
  EXPECT_TRUE(is_masked(at(40, 16)));
  EXPECT_TRUE(is_masked(at(41, 17)));
  EXPECT_FALSE(is_masked(at(42, 16)));
}

}  // namespace
}  // namespace raywalk::build_lf
