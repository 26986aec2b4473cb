#include <gtest/gtest.h>

#include "calibrate/rectify/rectify_set.h"

namespace raywalk::calibrate {
namespace {

// Two crossing lines of `count` stations, every other station `off_m` off its line.
std::vector<ListedFrame> cross(int count, double off_m) {
  std::vector<ListedFrame> frames;
  for (int i = 0; i < count; ++i) {
    const double along = 0.1 * i, off = i % 2 == 0 ? off_m : -off_m;
    frames.push_back({.file = "a" + std::to_string(i), .position_m = {along, 0.0, 0.45 + off}});
    frames.push_back({.file = "b" + std::to_string(i), .position_m = {0.45 + off, 0.0, along}});
  }
  return frames;
}

TEST(LineToleranceTest, ToleranceIsNeededOnlyIfTheDefaultFails) {
  EXPECT_EQ(line_tolerance_needed_mm(cross(10, 0.0), 2), 0.0);
  const auto needed = line_tolerance_needed_mm(cross(10, 0.02), 2);
  ASSERT_TRUE(needed);
  EXPECT_GE(*needed, 19.0);
  EXPECT_LE(*needed, 50.0);
}

TEST(LineToleranceTest, ToleranceOfTheCaptureIsTriedToo) {
  // One line with stations on both sides, by more than half the spacing.
  std::vector<ListedFrame> frames = cross(20, 0.15);
  std::erase_if(frames, [](const ListedFrame& frame) { return frame.file[0] == 'b'; });
  EXPECT_FALSE(line_tolerance_needed_mm(frames, 1));
  EXPECT_EQ(line_tolerance_needed_mm(frames, 1, {.off_line_m = 0.16}), 160.0);
}

TEST(LineToleranceTest, NoGridIsNotAnError) {
  EXPECT_FALSE(line_tolerance_needed_mm({}, 0));
  EXPECT_FALSE(line_tolerance_needed_mm({{.file = "one", .position_m = {0, 0, 0}}}, 1));
}

}  // namespace
}  // namespace raywalk::calibrate
