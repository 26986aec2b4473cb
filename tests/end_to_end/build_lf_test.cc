// End-to-end test of raywalk-build-lf, but for depth, and of views with what require has stored.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "build_lf/pack/test_pack.h"
#include "core/files/atomic_output.h"
#include "core/room/room.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class BuildLfTest : public ::testing::Test {
 protected:
  static CommandResult build_lf(const std::string& arguments) {
    return run_command(std::string(RAYWALK_BUILD_LF) + " " + arguments);
  }
  std::string pack_arguments() const {
    return "pack --frames " + capture_.list().string() + " --out " + room_;
  }

  // With a distance map of every n-th frame.
  void pack_with_distances(int every = 1) const {
    for (int frame = 0; frame < TestCapture::kStations; frame += every) {
      capture_.write_distance_map(frame, {32, 16});
    }
    expect_success(build_lf(pack_arguments() + " --distance " + capture_.distances().string()));
  }
  // Of pack, which must leave no files behind.
  void expect_clean_pack_error(const std::string& text) {
    expect_one_error(build_lf(pack_arguments()), 1, text);
    EXPECT_FALSE(fs::exists(capture_.room()));
    EXPECT_FALSE(fs::exists(capture_.partial()));
  }
  void replace_list(const std::string& rows) const {
    std::ofstream(capture_.list()) << "file,x,y,z\n" << rows;
  }

  TestCapture capture_;
  std::string room_ = capture_.room().string();
};

TEST_F(BuildLfTest, PacksInspectsAndVerifies) {
  capture_.write_distance_map(2, {32, 16});
  const std::string folder = capture_.root().string();  // of the list
  const CommandResult packed =
      expect_success(build_lf("pack --frames " + folder + " --out " + room_ + " --distance " +
                              capture_.distances().string()));
  EXPECT_THAT(packed.output, HasSubstr("4 lines, 1 cell, 28 panoramas of 64 x 32, 1 distance map"));
  EXPECT_THAT(packed.errors, HasSubstr("its positions are taken as listed"));
  const CommandResult info = expect_success(build_lf("info --json " + room_));
  const auto json = nlohmann::json::parse(info.output);
  EXPECT_EQ(json["lines"].size(), 4U);
  EXPECT_EQ(json["cells"].size(), 1U);
  EXPECT_EQ(json["stations"], 28);
  EXPECT_NEAR(json["lines"][0]["overhang_first_m"], 0.25, 1e-12);
  EXPECT_THAT(build_lf("info " + room_).output, HasSubstr("0.250 / 0.250"));
  EXPECT_THAT(expect_success(build_lf("verify " + room_)).output,
              AllOf(HasSubstr("28 panoramas and 1 distance maps match"),
                    HasSubstr("distances in use: given")));
}

TEST_F(BuildLfTest, ARoomWithSwappedOrMissingDistancesIsRefused) {
  pack_with_distances();
  const fs::path distances = capture_.room() / "distances" / "given";
  EXPECT_THAT(build_lf("distances " + room_).output, HasSubstr("views use the given distances"));
  fs::rename(distances / "x0.h5", distances / "q");
  fs::rename(distances / "x1.h5", distances / "x0.h5");
  fs::rename(distances / "q", distances / "x1.h5");
  expect_one_error(build_lf("verify " + room_), 1, "x0.h5: holds the distances of line x1");
  fs::remove(distances / "x0.h5");
  fs::rename(distances / "x1.h5", distances / "x0.h5");
  expect_one_error(build_lf("info " + room_), 1, "x1.h5: no such file");
  EXPECT_THAT(build_lf("distances " + room_).output, HasSubstr("not usable"));
  expect_one_error(build_lf("distances " + room_ + " --use estimated"), 1,
                   "raywalk-build-lf depth");
  expect_one_error(build_lf("distances " + room_ + " --use both"), 2, "give given or estimated");
  expect_one_error(build_lf("distances " + room_ + "/lines"), 1, "not a room");
}

TEST_F(BuildLfTest, ARefinedRoomSaysWhatItWasMadeFrom) {
  expect_one_error(build_lf("refine " + room_), 1, "room.lf");
  pack_with_distances(2);
  EXPECT_THAT(expect_success(build_lf("refine " + room_ + " --compress jpeg:95")).output,
              AllOf(HasSubstr("panoramas of 128 x 64"), HasSubstr("jpeg:95")));
  const fs::path out = capture_.room().parent_path() / "room-refined.lf";
  EXPECT_THAT(build_lf("info " + out.string()).output,
              HasSubstr("developed from 28 photographs of ../room.lf"));
  EXPECT_THAT(build_lf("verify " + out.string()).output, ::testing::Not(HasSubstr("changed")));
  fs::remove_all(capture_.room());
  EXPECT_THAT(build_lf("verify " + out.string()).output, HasSubstr("whether that has changed"));
  expect_one_error(build_lf("refine " + room_ + " --out " + room_ + "-2"), 1, room_);
}

TEST_F(BuildLfTest, ThreeLinesOfPythonOpenAVolume) {
  ASSERT_EQ(build_lf(pack_arguments()).exit_code, 0);
  const fs::path script = capture_.root() / "three_lines.py";
  std::ofstream(script) << "import h5py\n"
                           "f = h5py.File(\"room.lf/lines/x1.h5\")\n"
                           "print(f[\"rays\"][3, 40].shape, f[\"rays\"][3, 40][5].tolist())\n";
  const CommandResult python =
      run_command("cd " + capture_.root().string() + " && /usr/bin/python3 three_lines.py");
  // Line x1 is the front line, whose frames are the first of the list.
  const cv::Vec3b rgb = TestCapture::colour(3, 40, 5);
  EXPECT_EQ(python.output, fmt::format("(32, 3) [{}, {}, {}]\n", rgb[0], rgb[1], rgb[2]))
      << python.errors;
}

TEST_F(BuildLfTest, WrongUsageIsExitCodeTwo) {
  expect_one_error(build_lf(""), 2, "subcommand");
  expect_one_error(build_lf("pack --out room.lf"), 2, "--frames");
  expect_one_error(build_lf(pack_arguments() + " --line-tolerance-mm -1"), 2,
                   "--line-tolerance-mm");
  expect_one_error(build_lf("info --yaml room.lf"), 2, "--yaml");
}

TEST_F(BuildLfTest, BadInputGivesOneErrorLineAndLeavesNothing) {
  fs::resize_file(capture_.path(7), 100);
  expect_clean_pack_error("back_0.png");
  capture_.write_frame(7, {32, 16});
  expect_clean_pack_error("all frames must have one size");
  capture_.write_frame(7, {64, 31});
  expect_clean_pack_error("back_0.png");
  for (const auto& [rows, error] : std::vector<std::pair<std::string, std::string>>{
           {"front_1.png,nan,0,0\n", "poses.csv:3"},
           {"front_1.png,0.1,0,0\nfront_2.png,0.1,0,0\n", "poses.csv:4) have the same position"},
           {"", "at least two"}}) {
    replace_list("front_0.png,0,0,0\n" + rows);
    expect_clean_pack_error(error);
  }
  replace_list("");
  expect_clean_pack_error("no frames");
  fs::remove(capture_.list());
  expect_clean_pack_error("poses.csv");
}

TEST_F(BuildLfTest, ADamagedRoomIsNamed) {
  expect_success(build_lf(pack_arguments()));
  const fs::path volume = line_volume_path(capture_.room(), "z0");
  std::string flipped = read_file(volume);
  flipped[flipped.size() / 2] ^= 4;
  write_file_atomically(volume, flipped);
  expect_one_error(build_lf("verify " + room_), 1, "line z0 station 3 (left_3.png)");
  fs::resize_file(volume, flipped.size() - 1);
  for (const char* command : {"info ", "verify "}) {
    expect_one_error(build_lf(command + room_), 1, "z0.h5");
  }
}

TEST_F(BuildLfTest, RequireThatFailsLeavesNothing) {
  expect_success(build_lf(pack_arguments()));
  const fs::path thin = capture_.root() / "thin.lf";
  const CommandResult blind = build_lf("require " + room_ + " --thin " + thin.string());
  expect_one_error(blind, 1, "raywalk-build-lf depth");
  EXPECT_THAT(blind.errors, HasSubstr("pack --distance"));
  EXPECT_FALSE(fs::exists(thin));
  EXPECT_FALSE(fs::exists(capture_.room() / "require.json"));
  expect_one_error(build_lf("require " + room_ + " --tolerance-px nan"), 2, "--tolerance-px");
}

TEST_F(BuildLfTest, UnwritableOutputIsNamed) {
  // A file in place of a directory is an error even for root.
  const std::string frames = "pack --frames " + capture_.list().string();
  expect_one_error(build_lf(frames + " --out " + (capture_.list() / "room.lf").string()), 1,
                   "poses.csv/room.lf");
  expect_one_error(build_lf(frames + " --out /proc/room.lf"), 1, "/proc/room.lf");
}

// A file size limit simulates a full disk: writes fail in the same way.
TEST_F(BuildLfTest, FullDiskLeavesNothing) {
  for (int blocks : {0, 1, 4, 16, 41, 82}) {  // of 512 bytes
    // Through a pipe, as the log file must not hit the limit.
    const std::string errors = run_command(fmt::format("(ulimit -f {}; {} {} 2>&1) | cat >&2",
                                                       blocks, RAYWALK_BUILD_LF, pack_arguments()))
                                   .errors;
    EXPECT_THAT(errors, HasSubstr("error: ")) << blocks;
    // Words of HDF5 that tell a user nothing.
    for (const char* word : {"HDF5-DIAG", "bytes actually written", "errno"}) {
      EXPECT_THAT(errors, ::testing::Not(HasSubstr(word)));
    }
    EXPECT_FALSE(fs::exists(capture_.room())) << blocks;
    EXPECT_FALSE(fs::exists(capture_.partial())) << blocks;
  }
}

// The limit allows the line of two stations but not that of seven; then it is lifted.
TEST_F(BuildLfTest, RunStoppedByAFullDiskIsResumed) {
  std::string rows = "back_0.png,0,0,-1\nback_1.png,0.25,0,-1\n";
  for (int i = 0; i < 7; ++i) rows += fmt::format("front_{}.png,{},0,0\n", i, 0.25 * i);
  replace_list(rows);
  const CommandResult stopped =
      run_command("ulimit -f 64; " + std::string(RAYWALK_BUILD_LF) + " " + pack_arguments());
  expect_one_error(stopped, 1, "x1");
  EXPECT_FALSE(fs::exists(capture_.room()));
  const fs::path finished = line_volume_path(capture_.partial(), "x0");
  ASSERT_TRUE(fs::exists(finished));
  const auto written = fs::last_write_time(finished);
  EXPECT_EQ(build_lf(pack_arguments()).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(line_volume_path(capture_.room(), "x0")), written);
  EXPECT_EQ(build_lf("verify " + room_).exit_code, 0);
  EXPECT_FALSE(fs::exists(capture_.partial()));
}

TEST_F(BuildLfTest, InterruptedRunKeepsFinishedLinesAndIsResumed) {
  const fs::path finished = line_volume_path(capture_.partial(), "x0");
  const std::string frames = RAYWALK_TEST_ROOM "/poses.csv";
  int exit_code = 0;
  // A run may be over before the signal.
  for (int attempt = 0; attempt < 5 && exit_code == 0; ++attempt) {
    fs::remove_all(capture_.room());
    exit_code = exit_code_when_stopped(
        {RAYWALK_BUILD_LF, "pack", "--frames", frames, "--out", room_, "--threads", "1"}, SIGINT,
        [&] { return fs::exists(finished); });
  }
  EXPECT_EQ(exit_code, 130);
  EXPECT_FALSE(fs::exists(capture_.room()));
  ASSERT_TRUE(fs::exists(finished));
  const auto written = fs::last_write_time(finished);
  // Resuming with other inputs is refused.
  expect_one_error(build_lf(pack_arguments()), 1, "holds an unfinished room of other frames");
  EXPECT_THAT(expect_success(build_lf("pack --frames " + frames + " --out " + room_)).output,
              HasSubstr("4 lines, 1 cell, 124 panoramas of 512 x 256"));
  EXPECT_EQ(fs::last_write_time(line_volume_path(capture_.room(), "x0")), written);
  EXPECT_EQ(build_lf("verify " + room_).exit_code, 0);
}

TEST_F(BuildLfTest, RequireMeasuresAndThins) {
  pack_with_distances();
  const std::string thin = (capture_.root() / "thin.lf").string();
  const std::string report = (capture_.root() / "report").string();
  const CommandResult done =
      expect_success(build_lf("require " + room_ + " --thin " + thin + " --report " + report));
  EXPECT_THAT(done.output,
              AllOf(HasSubstr("layers"), HasSubstr("spacing"), HasSubstr("index.html")));
  EXPECT_EQ(build_lf("verify " + thin).exit_code, 0);
  const auto json = nlohmann::json::parse(read_file(fs::path(report) / "require.json"));
  EXPECT_EQ(json["spacing"]["stations"], TestCapture::kStations);
  EXPECT_EQ(json["thinned"]["room"], thin);
  expect_success(run_command(std::string(RAYWALK_RENDER) + " view " + room_ + " --at 0,0 --out " +
                             (capture_.root() / "a.png").string()));
}

}  // namespace
}  // namespace raywalk::build_lf
