#include "core/files/frame_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/listed_files.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

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

TEST_F(FrameListTest, FilesAndMasksAreRelativeToTheList) {
  const std::vector<Frame> frames =
      read("file,x,y,z,mask\ncapture/a.jpg,1,2,3,masks/a.png\n/abs/b.jpg,4,5,6,\n");
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].path, directory_ / "capture/a.jpg");
  EXPECT_EQ(frames[0].file, "capture/a.jpg");
  EXPECT_EQ(frames[0].mask, directory_ / "masks/a.png");
  EXPECT_EQ(frames[0].position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(frames[0].attitude.has_value());
  EXPECT_EQ(frames[1].path, "/abs/b.jpg");
  EXPECT_FALSE(frames[1].mask.has_value());
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

TEST_F(FrameListTest, TextRoundTrips) {
  const Attitude attitude{0.1, -0.2, 3.0};
  const std::vector<Frame> back =
      read(frame_list_text({{.file = "plain.png",
                             .position_m = {1.0 / 3.0, -0.0, 1e-9},
                             .mask = "masks/plain.png",
                             .line = "x0"},
                            {.file = "a, \"b\".png", .position_m = {0, 0, 0}, .attitude = attitude},
                            {.file = "#x.png", .position_m = {-5, 2, 1}}}));
  ASSERT_EQ(back.size(), 3U);
  EXPECT_EQ(back[0].file, "plain.png");
  EXPECT_NEAR(back[0].position_m.x(), 1.0 / 3.0, 1e-9);
  EXPECT_FALSE(back[0].attitude);
  EXPECT_EQ(back[0].mask.value().filename(), "plain.png");
  EXPECT_EQ(back[0].line, "x0");
  EXPECT_EQ(back[1].line, "");
  EXPECT_EQ(back[1].file, "a, \"b\".png");
  EXPECT_NEAR(back[1].attitude.value().roll_rad, 3.0, 1e-9);
  EXPECT_FALSE(back[1].mask);
  EXPECT_EQ(back[2].file, "#x.png");
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

TEST(ListedFiles, NamesOfOtherSystemsAreFound) {
  const TestDirectory directory;
  const std::string composed = "K\u00fcche.jpg", decomposed = "Ku\u0308che.jpg";
  fs::create_directories(directory / "Hall/Front");
  for (const std::string name : {"Hall/Front/a.JPG", "b.jpg", "B.jpg", "\xFFg.jpg"}) {
    write_file_atomically(directory / name, name);
  }
  write_file_atomically(directory / decomposed, "");
  ListedFiles files(directory.path());
  const auto found = [&](const std::string& name) {
    return files.find(name).lexically_relative(directory.path()).string();
  };
  EXPECT_EQ(found("Hall/Front/a.JPG"), "Hall/Front/a.JPG");
  EXPECT_EQ(found("Hall\\Front\\a.JPG"), "Hall/Front/a.JPG");
  EXPECT_EQ(found("hall\\FRONT\\A.jpg"), "Hall/Front/a.JPG");
  EXPECT_EQ(found("Hall/../hall/./Front/a.jpg"), "Hall/../Hall/./Front/a.JPG");
  EXPECT_EQ(found(composed), decomposed);
  EXPECT_EQ(found(decomposed), decomposed);
  EXPECT_EQ(found("\xFFg.JPG"), "\xFFg.JPG") << "not UTF-8";
  EXPECT_EQ(found("b.jpg"), "b.jpg");
  EXPECT_EQ(found("b.JPG"), "b.JPG") << "two files have this name but for case";
  EXPECT_EQ(found("none\\c.jpg"), "none\\c.jpg");
  EXPECT_EQ(files.find((directory / "HALL/front/a.jpg").string()), directory / "Hall/Front/a.JPG");
}

TEST(ListedFiles, AFileWithABackslashInItsNameIsTakenAsWritten) {
  const TestDirectory directory;
  write_file_atomically(directory / "a\\b.jpg", "");
  EXPECT_EQ(ListedFiles(directory.path()).find("a\\b.jpg"), directory / "a\\b.jpg");
}

// Examples of FIPS 180-2, appendix B, and the empty message.
TEST(Fingerprint, GivesThePublishedChecksums) {
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Fingerprint, OfPixelsDoesNotDependOnGapsBetweenRows) {
  const cv::Mat whole = (cv::Mat_<std::uint8_t>(2, 3) << 'a', 'b', 'x', 'c', 'd', 'x');
  const cv::Mat part = whole.colRange(0, 2);
  ASSERT_FALSE(part.isContinuous());
  EXPECT_EQ(sha256_of_pixels(part), sha256_hex("abcd"));
}

TEST(Fingerprint, OfAFileIsThatOfItsBytesAndItsStampChangesWithSizeAndTime) {
  const TestDirectory directory;
  const fs::path file = directory / "frame.png";
  write_file_atomically(file, "abc");
  EXPECT_EQ(sha256_of_file(file), sha256_hex("abc"));
  EXPECT_THROW(sha256_of_file(directory / "nothing.png"), Error);
  EXPECT_THROW(sha256_of_file(directory.path()), Error);
  const std::string before = stamp_of(file).text();
  EXPECT_EQ(stamp_of(file).bytes, 3U);
  fs::last_write_time(file, fs::last_write_time(file) + std::chrono::seconds(1));
  EXPECT_NE(stamp_of(file).text(), before);
  EXPECT_THAT(error_of([&] { stamp_of(directory / "nothing.png"); }),
              testing::HasSubstr("nothing.png: cannot be read"));
}

}  // namespace
}  // namespace raywalk
