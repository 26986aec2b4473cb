#include <gtest/gtest.h>

#include "calibrate/rectify/rectify_set.h"

namespace raywalk::calibrate {
namespace {

// Two crossing lines of 20 stations, every other station `off_m` off its line.
std::vector<ListedFrame> cross(double off_m) {
  std::vector<ListedFrame> frames;
  for (int i = 0; i < 20; ++i) {
    const double along = 0.1 * i, off = i % 2 == 0 ? off_m : -off_m;
    const std::string number = std::to_string(i);
    frames.push_back({.file = "a" + number, .position_m = {along, 0.0, 0.45 + off}, .line = "a"});
    frames.push_back({.file = "b" + number, .position_m = {0.45 + off, 0.0, along}, .line = "b"});
  }
  return frames;
}

TEST(LineToleranceTest, ThatOfTheCaptureIsNeededOnlyIfTheDefaultFails) {
  EXPECT_EQ(line_tolerance_needed_mm(cross(0.0)), 0.0);
  EXPECT_EQ(line_tolerance_needed_mm(cross(0.04), {.off_line_m = 0.16}), 0.0);
  EXPECT_EQ(line_tolerance_needed_mm(cross(0.15), {.off_line_m = 0.18}), 180.0);
  EXPECT_FALSE(line_tolerance_needed_mm(cross(0.15)));
}

TEST(LineToleranceTest, NoGridIsNotAnError) {
  EXPECT_FALSE(line_tolerance_needed_mm({}));
  EXPECT_FALSE(line_tolerance_needed_mm({{.file = "one", .position_m = {0, 0, 0}, .line = "a"}}));
}

}  // namespace
}  // namespace raywalk::calibrate
