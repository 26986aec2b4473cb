// gt.csv beside poses.csv: frames that are held out of the lines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/base/test_capture_folder.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class HeldOutTest : public ::testing::Test {
 protected:
  HeldOutTest() {
    folder_.write_cross();
    for (const char* file : {"gt/t0.png", "gt/t1.png", "gt/a0.png"}) folder_.add_picture(file);
  }
  void write_truth(const std::string& rows, const std::string& columns = "file,x,y,z") const {
    write_file_atomically(folder_ / "gt.csv", columns + "\n" + rows);
  }
  std::string error() const { return folder_.read_error(); }

  TestCaptureFolder folder_;
};

TEST_F(HeldOutTest, FramesFollowTheStationsAndAreOnNoLine) {
  const CaptureSet without = folder_.read();
  write_truth("gt/t0.png,0.05,0,0.05,3,0,0\ngt/t1.png,0,0,0,0,0,0\n", "file,x,y,z,yaw,pitch,roll");
  const CaptureSet set = folder_.read();
  EXPECT_EQ(set.stations(), 6U);
  ASSERT_EQ(set.frames.size(), 8U);
  EXPECT_EQ(set.frames[6].name, "t0");
  EXPECT_TRUE(set.frames[6].held_out());
  EXPECT_NEAR(set.frames[6].nominal_attitude->yaw_rad, radians_from_degrees(3.0), 1e-12);
  ASSERT_EQ(set.lines.size(), without.lines.size());
  for (std::size_t i = 0; i < set.lines.size(); ++i) {
    EXPECT_EQ(set.lines[i].frames, without.lines[i].frames);
  }
  for (std::size_t i = 0; i < without.frames.size(); ++i) {
    EXPECT_EQ(set.frames[i].name, without.frames[i].name);
  }
  EXPECT_EQ(stations_only(set).frames.size(), 6U);
}

TEST_F(HeldOutTest, NameOfAStationIsNotTakenAgain) {
  write_truth("gt/t0.png,0,0,0\ngt/a0.png,0,0,0\n");
  const CaptureSet set = folder_.read();
  EXPECT_EQ(set.frames[6].name, "gt_t0");
  EXPECT_EQ(set.frames[7].name, "gt_a0");
  EXPECT_TRUE(indices_by_name(set).contains("a0"));
  folder_.add_picture("a0.jpg");
  write_truth("a0.jpg,0,0,0\n");
  EXPECT_THAT(error(), AllOf(HasSubstr("gt.csv: "), HasSubstr("extension")));
}

TEST_F(HeldOutTest, StationIsNotHeldOutAtOnce) {
  for (const char* file : {"a1.png", "./a1.png", "gt/../a1.png"}) {
    write_truth(fmt::format("gt/t0.png,0,0,0\n{},0,0,0\n", file));
    EXPECT_THAT(error(), AllOf(HasSubstr("gt.csv:3: "), HasSubstr("a1.png"),
                               HasSubstr("poses.csv:3"), HasSubstr("held out")))
        << file;
  }
}

TEST_F(HeldOutTest, UnusableRowsAreNamed) {
  write_truth("gt/t0.png,nan,0,0\n");
  EXPECT_THAT(error(), AllOf(HasSubstr("gt.csv:2"), HasSubstr("x")));
  write_truth("gt/t0.png,0,0,2e6\n");
  EXPECT_THAT(error(), AllOf(HasSubstr("gt.csv:2"), HasSubstr("z = 2e+06")));
  write_truth("");
  EXPECT_THAT(error(), HasSubstr("gt.csv: lists no frames"));
  write_truth("gt/nowhere.png,0,0,0\n");
  EXPECT_THAT(error(), HasSubstr("nowhere.png"));
  folder_.add_picture("gt/t0.png", {32, 16});
  write_truth("gt/a0.png,0,0,0\ngt/t0.png,0,0,0\n");
  EXPECT_THAT(error(),
              AllOf(HasSubstr("gt.csv:3: "), HasSubstr("gt/t0.png is 32x16"), HasSubstr("16x8")));
  std::filesystem::remove(folder_ / "gt.csv");
  std::filesystem::create_symlink("nowhere.csv", folder_ / "gt.csv");
  EXPECT_THAT(error(), HasSubstr("gt.csv"));
}

}  // namespace
}  // namespace raywalk::calibrate
