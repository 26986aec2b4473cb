#include "core/files/frame_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class FrameListTest : public ::testing::Test {
 protected:
  std::vector<Frame> read(const std::string& text) {
    write_file_atomically(list_, text);
    return read_frame_list(list_);
  }
  std::string error_in(const std::string& text) {
    return error_of([&] { read(text); });
  }

  TestDirectory directory_;
  std::filesystem::path list_ = directory_ / "poses.csv";
};

TEST_F(FrameListTest, FilesAreRelativeToTheList) {
  const std::vector<Frame> frames = read("file,x,y,z\ncapture/a.jpg,1,2,3\n/abs/b.jpg,4,5,6\n");
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].path, directory_ / "capture/a.jpg");
  EXPECT_EQ(frames[0].file, "capture/a.jpg");
  EXPECT_EQ(frames[1].path, "/abs/b.jpg");
  EXPECT_EQ(frames[0].position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(frames[0].attitude.has_value());
}

TEST_F(FrameListTest, AnglesAreDegreesAndMissingOnesZero) {
  const std::vector<Frame> frames =
      read("file,x,y,z,yaw,roll\na.jpg,0,0,0,90,-45\nb.jpg,0,0,1,0,0\n");
  ASSERT_TRUE(frames[0].attitude.has_value());
  EXPECT_DOUBLE_EQ(frames[0].attitude->yaw_rad, kHalfPi);
  EXPECT_DOUBLE_EQ(frames[0].attitude->pitch_rad, 0.0);
  EXPECT_DOUBLE_EQ(frames[0].attitude->roll_rad, -0.25 * kPi);
  EXPECT_FALSE(frames[1].attitude.has_value());
}

TEST_F(FrameListTest, MasksAreRelativeToTheListAndMayBeLeftOut) {
  const std::vector<Frame> frames =
      read("file,x,y,z,mask\na.jpg,0,0,0,masks/a.png\nb.jpg,0,0,1,\n");
  EXPECT_EQ(frames[0].mask, directory_ / "masks/a.png");
  EXPECT_FALSE(frames[1].mask.has_value());
  EXPECT_FALSE(read("file,x,y,z\na.jpg,0,0,0\n")[0].mask.has_value());
}

TEST_F(FrameListTest, OtherColumnsAreIgnoredWhereThatIsSaid) {
  const std::string text = "file,x,y,z,distance\na.jpg,0,0,0,a.png\n";
  EXPECT_THAT(error_in(text), HasSubstr("distance"));
  EXPECT_EQ(read_frame_list(list_, {"distance"})[0].file, "a.jpg");
}

TEST_F(FrameListTest, BadRowsAreNamedByLine) {
  EXPECT_THAT(error_in("file,x,y,z\na.jpg,0,0,0\nb.jpg,nan,0,0\n"), HasSubstr("poses.csv:3"));
  EXPECT_THAT(error_in("file,x,y,z\na.jpg,0,0,2000000\n"), HasSubstr("position in metres"));
  EXPECT_THAT(error_in("file,x,y,z\na.jpg,0,1e308,0\n"),
              AllOf(HasSubstr("poses.csv:2: y = 1e+308"), HasSubstr("correct the unit")));
  EXPECT_THAT(error_in("file,x,y,z,yaw\na.jpg,0,0,0,1e308\n"),
              AllOf(HasSubstr("poses.csv:2: yaw = 1e+308"), HasSubstr("angle in degrees")));
  EXPECT_THAT(error_in("file,x,y,z\n,0,0,0\n"), HasSubstr("names no file"));
  EXPECT_THAT(error_in("file,x,y,z\n"), HasSubstr("no frames"));
  EXPECT_THAT(error_in("file,x,y,z\na.jpg,0,0,0\nb.jpg,0,0,1\na.jpg,1,0,0\n"),
              AllOf(HasSubstr("poses.csv:4"), HasSubstr("poses.csv:2"), HasSubstr("a.jpg")));
}

std::vector<Frame> written_and_read(const std::vector<ListedFrame>& frames) {
  const TestDirectory directory;
  write_file_atomically(directory / "poses.csv", frame_list_text(frames));
  return read_frame_list(directory / "poses.csv");
}

TEST(FrameListText, RoundTrips) {
  const Attitude attitude{0.1, -0.2, 3.0};
  const std::vector<Frame> read =
      written_and_read({{.file = "plain.png",
                         .position_m = {1.0 / 3.0, -0.0, 1e-9},
                         .mask = "masks/plain.png",
                         .line = "x0"},
                        {.file = "a, \"b\".png", .position_m = {0, 0, 0}, .attitude = attitude},
                        {.file = "#x.png", .position_m = {-5, 2, 1}}});
  ASSERT_EQ(read.size(), 3U);
  EXPECT_EQ(read[0].file, "plain.png");
  EXPECT_NEAR(read[0].position_m.x(), 1.0 / 3.0, 1e-9);
  EXPECT_FALSE(read[0].attitude);
  ASSERT_TRUE(read[0].mask);
  EXPECT_EQ(read[0].mask->filename(), "plain.png");
  EXPECT_EQ(read[0].line, "x0");
  EXPECT_EQ(read[1].line, "");
  EXPECT_EQ(read[1].file, "a, \"b\".png");
  ASSERT_TRUE(read[1].attitude);
  EXPECT_NEAR(read[1].attitude->roll_rad, 3.0, 1e-9);
  EXPECT_FALSE(read[1].mask);
  EXPECT_EQ(read[2].file, "#x.png");
}

TEST(FrameListText, HasColumnsOnlyWhereTheyAreNeeded) {
  EXPECT_EQ(frame_list_text({{.file = "a.png", .position_m = {1, -1e-12, -2}}}),
            "file,x,y,z\na.png,1.000000000,0.000000000,-2.000000000\n");
}

TEST(FrameNames, AreStemsOrPaths) {
  EXPECT_THAT(frame_names(std::vector<std::string>{"a/0.png", "b/1.png"}, "poses.csv"),
              ::testing::ElementsAre("0", "1"));
  EXPECT_THAT(frame_names(std::vector<std::string>{"a/0.png", "b/0.png"}, "poses.csv"),
              ::testing::ElementsAre("a_0", "b_0"));
  EXPECT_THROW(frame_names(std::vector<std::string>{"a/0.png", "a/0.jpg"}, "poses.csv"), Error);
}

}  // namespace
}  // namespace raywalk
