// End-to-end test of raywalk-simulate room, up to the packed room. RAYWALK_SIMULATE and
// RAYWALK_BUILD_LF are the programs.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/files/csv.h"
#include "core/files/image_file.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

// Five stations on each of four lines.
const char* const kSmall =
    "grid:\n  spacing_mm: 250\n  overhang_share: 0\noutput:\n  width_px: 128\n";

class VirtualRoomTest : public ::testing::Test {
 protected:
  CommandResult capture(const std::string& yaml, const std::string& arguments = "") const {
    write_file_atomically(config(), yaml);
    return run_command(command(arguments));
  }
  std::string command(const std::string& arguments) const {
    return fmt::format("{} room {} --out {} {}", RAYWALK_SIMULATE, config().string(),
                       out().string(), arguments);
  }
  fs::path config() const { return directory_ / "room.yaml"; }
  fs::path out() const { return directory_ / "room"; }

  // Expects one error line and no files except the settings.
  void expect_clean_error(const CommandResult& result, int exit_code,
                          const std::string& text) const {
    expect_one_error(result, exit_code, text);
    EXPECT_EQ(directory_.entries(), 1U);
  }

  TestDirectory directory_;
};

TEST_F(VirtualRoomTest, CapturePacksWithItsDistances) {
  EXPECT_THAT(expect_success(capture(kSmall, "--every-distance 2")).output,
              HasSubstr("20 panoramas of 128 x 64 on 4 lines, 12 true views, 24 distance maps"));
  EXPECT_FALSE(fs::exists(out() / "true_poses.csv"));
  const CommandResult done = expect_success(
      run_command(fmt::format("{} pack --frames {}/poses.csv --distance {}/dist --out {}.lf",
                              RAYWALK_BUILD_LF, out().string(), out().string(), out().string())));
  EXPECT_THAT(done.output, HasSubstr("4 lines, 1 cell, 20 panoramas of 128 x 64, 12 distance"));
  const CsvTable truth = CsvTable::read(out() / "gt.csv", {"file", "x", "y", "z"}, {"distance"});
  ASSERT_EQ(truth.rows(), 12U);
  for (std::size_t row = 0; row < truth.rows(); ++row) {
    const fs::path file = out() / truth.text(row, "file");
    EXPECT_EQ(read_panorama(file).cols, 128);
    const cv::Mat distance =
        read_distance_map(out() / "dist" / ("gt_" + file.stem().string() + ".png"));
    double nearest_mm = 0.0, farthest_mm = 0.0;
    cv::minMaxLoc(distance, &nearest_mm, &farthest_mm);
    EXPECT_GT(farthest_mm, 1000.0);
    EXPECT_LT(farthest_mm, 10000.0);
  }
}

TEST_F(VirtualRoomTest, SameSettingsGiveTheSameFiles) {
  ASSERT_EQ(capture(kSmall, "--threads 1 --truth-views 1").exit_code, 0);
  fs::rename(out(), directory_ / "first");
  ASSERT_EQ(capture(kSmall, "--threads 3 --truth-views 1").exit_code, 0);
  expect_success(
      run_command(fmt::format("diff -r {} {}", (directory_ / "first").string(), out().string())));
}

TEST_F(VirtualRoomTest, FormatViewsAndSceneAreApplied) {
  write_file_atomically(directory_ / "views.csv", "name,x,z\nhere,0.1,0.2\n");
  const std::string views = "--views " + (directory_ / "views.csv").string() + " --width 64";
  const std::string png = std::string(kSmall) + "  format: png\n";
  ASSERT_EQ(capture(png, views).exit_code, 0);
  EXPECT_EQ(read_panorama(out() / "gt/here.png").cols, 64);
  const cv::Mat first = read_panorama(out() / "capture/x0_000.png");
  fs::remove_all(out());
  ASSERT_EQ(capture(png + "scene: {file: study}\n", views).exit_code, 0);
  EXPECT_GT(cv::norm(first, read_panorama(out() / "capture/x0_000.png"), cv::NORM_INF), 50.0);
}

// A scene of one's own, named beside the settings, in which somebody walks.
TEST_F(VirtualRoomTest, OwnScenesAreReadFromTheSettingsFolder) {
  write_file_atomically(directory_ / "mine.yaml",
                        "include: [empty, person]\n"
                        "instances:\n"
                        "  - {object: man, at: [0, -1.3, 0], step_m: 0.5,\n"
                        "     loop: [-1.2, -1.2, 1.2, -1.2, 1.2, 1.2, -1.2, 1.2]}\n");
  expect_success(capture(std::string(kSmall) + "scene: {file: mine.yaml}\n", "--truth-views 1"));
  const cv::Mat first = cv::imread((out() / "people/x0_000.png").string(), cv::IMREAD_GRAYSCALE);
  const cv::Mat second = cv::imread((out() / "people/x0_001.png").string(), cv::IMREAD_GRAYSCALE);
  EXPECT_GT(cv::countNonZero(first), 50);
  EXPECT_GT(cv::countNonZero(first != second), 50);
}

// The frame header (ITU-T T.81, B.2.2) holds the sampling factors of each component.
TEST_F(VirtualRoomTest, JpegKeepsColorInFullResolution) {
  ASSERT_EQ(capture(kSmall, "--truth-views 0").exit_code, 0);
  const std::string jpeg = read_file(out() / "capture/x0_000.jpg");
  const std::size_t frame = jpeg.find("\xFF\xC0");
  ASSERT_NE(frame, std::string::npos);
  EXPECT_EQ(jpeg[frame + 9], 3);      // components
  EXPECT_EQ(jpeg[frame + 11], 0x11);  // luma is sampled like chroma
}

TEST_F(VirtualRoomTest, WrongUsageIsExitCodeTwo) {
  expect_clean_error(capture("seeds: 1\n"), 2, "did you mean 'seed'?");
  expect_clean_error(capture("scene: {file: romo}\n"), 2, "did you mean 'room'?");
  expect_clean_error(capture(kSmall, "--width 130"), 2, "multiple of 4");
  expect_clean_error(capture(kSmall, "--truth-views -1"), 2, "--truth-views");
  expect_clean_error(capture(kSmall, "--views a.csv --truth-views 3"), 2, "--views");
}

TEST_F(VirtualRoomTest, BadViewsLeaveNothing) {
  expect_clean_error(capture(kSmall, "--views missing.csv"), 1, "missing.csv");
  const TestDirectory elsewhere;
  write_file_atomically(elsewhere / "views.csv", "name,x,z\nfar,100,0\n");
  expect_clean_error(capture(kSmall, "--views " + (elsewhere / "views.csv").string()), 1,
                     "outside the room");
}

TEST_F(VirtualRoomTest, ExistingOrImpossibleOutputIsRefused) {
  fs::create_directory(out());
  expect_one_error(capture(kSmall), 1, "exists already");
  EXPECT_TRUE(fs::is_empty(out()));
  fs::remove(out());
  const CommandResult in_a_file = run_command(fmt::format(
      "{} room {} --out {}/room", RAYWALK_SIMULATE, config().string(), config().string()));
  expect_clean_error(in_a_file, 1, "cannot make");
}

// A file size limit simulates a full disk: writes fail in the same way.
TEST_F(VirtualRoomTest, FullDiskLeavesNothing) {
  write_file_atomically(config(), kSmall);
  const CommandResult full =
      run_command("(ulimit -f 8; " + command("") + " 2>&1) | cat >&2");  // 8 blocks of 512 bytes
  EXPECT_THAT(full.errors, HasSubstr("error: cannot write"));
  EXPECT_EQ(directory_.entries(), 1U);
}

TEST_F(VirtualRoomTest, InterruptLeavesNothing) {
  write_file_atomically(config(), "seed: 1\n");  // 244 stations, far longer than the test waits
  // The partial directory shows that work has begun.
  EXPECT_EQ(
      exit_code_when_stopped({RAYWALK_SIMULATE, "room", config().string(), "--out", out().string()},
                             SIGINT, [&] { return directory_.entries() > 1; }),
      130);
  EXPECT_EQ(directory_.entries(), 1U);
}

}  // namespace
}  // namespace raywalk
