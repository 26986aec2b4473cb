#include "calibrate/rectify/frame_tables.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

std::vector<Frame> written_and_read(const std::vector<ListedFrame>& frames) {
  const TestDirectory directory;
  write_file_atomically(directory / "poses.csv", frame_list_text(frames));
  return read_frame_list(directory / "poses.csv");
}

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

TEST(FrameTablesTest, ListRoundTrips) {
  const Attitude attitude{0.1, -0.2, 3.0};
  const std::vector<Frame> read = written_and_read(
      {{.file = "plain.png", .position_m = {1.0 / 3.0, -0.0, 1e-9}, .mask = "masks/plain.png"},
       {.file = "a, \"b\".png", .position_m = {0, 0, 0}, .attitude = attitude},
       {.file = "#x.png", .position_m = {-5, 2, 1}}});
  ASSERT_EQ(read.size(), 3U);
  EXPECT_EQ(read[0].file, "plain.png");
  EXPECT_NEAR(read[0].position_m.x(), 1.0 / 3.0, 1e-9);
  EXPECT_FALSE(read[0].attitude);
  ASSERT_TRUE(read[0].mask);
  EXPECT_EQ(read[0].mask->filename(), "plain.png");
  EXPECT_EQ(read[1].file, "a, \"b\".png");
  ASSERT_TRUE(read[1].attitude);
  EXPECT_NEAR(read[1].attitude->roll_rad, 3.0, 1e-9);
  EXPECT_FALSE(read[1].mask);
  EXPECT_EQ(read[2].file, "#x.png");
}

TEST(FrameTablesTest, ColumnsAppearOnlyWhereTheyAreNeeded) {
  EXPECT_EQ(frame_list_text({{.file = "a.png", .position_m = {1, -0.0, -2}}}),
            "file,x,y,z\na.png,1.000000000,0.000000000,-2.000000000\n");
}

TEST(FrameTablesTest, ToleranceIsNeededOnlyIfTheDefaultFails) {
  EXPECT_EQ(line_tolerance_needed_mm(cross(10, 0.0), 2), 0.0);
  const auto needed = line_tolerance_needed_mm(cross(10, 0.02), 2);
  ASSERT_TRUE(needed);
  EXPECT_GE(*needed, 19.0);
  EXPECT_LE(*needed, 50.0);
}

TEST(FrameTablesTest, ToleranceOfTheCaptureIsTriedToo) {
  // One line with stations on both sides, by more than half the spacing.
  std::vector<ListedFrame> frames = cross(20, 0.15);
  std::erase_if(frames, [](const ListedFrame& frame) { return frame.file[0] == 'b'; });
  EXPECT_FALSE(line_tolerance_needed_mm(frames, 1));
  EXPECT_EQ(line_tolerance_needed_mm(frames, 1, {.off_line_m = 0.16}), 160.0);
}

TEST(FrameTablesTest, NoGridIsNotAnError) {
  EXPECT_FALSE(line_tolerance_needed_mm({}, 0));
  EXPECT_FALSE(line_tolerance_needed_mm({{.file = "one", .position_m = {0, 0, 0}}}, 1));
}

}  // namespace
}  // namespace raywalk::calibrate
