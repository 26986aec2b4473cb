// End-to-end test of raywalk-build-lf. RAYWALK_BUILD_LF is the program, RAYWALK_TEST_ROOM the
// embedded capture.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "build_lf/pack/test_capture.h"
#include "core/room/room.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

class BuildLfTest : public ::testing::Test {
 protected:
  static CommandResult build_lf(const std::string& arguments) {
    return run_command(std::string(RAYWALK_BUILD_LF) + " " + arguments);
  }
  std::string pack_arguments() const {
    return "pack --frames " + capture_.list().string() + " --out " + capture_.room().string();
  }

  // Expects failure with this exit code and exactly one error line.
  static void expect_error(const CommandResult& result, int exit_code, const std::string& text) {
    EXPECT_EQ(result.exit_code, exit_code);
    EXPECT_THAT(result.errors, HasSubstr(text));
    size_t lines = 0;
    for (size_t at = 0;
         (at = result.errors.find("raywalk-build-lf: error: ", at)) != std::string::npos; ++at)
      ++lines;
    EXPECT_EQ(lines, 1U) << result.errors;
    EXPECT_EQ(result.errors.find("HDF5-DIAG"), std::string::npos) << result.errors;
  }
  // The same for pack, which must leave no files behind.
  void expect_clean_pack_error(const std::string& text) {
    expect_error(build_lf(pack_arguments()), 1, text);
    EXPECT_FALSE(fs::exists(capture_.room()));
    EXPECT_FALSE(fs::exists(capture_.partial()));
  }
  void replace_list(const std::string& rows) const {
    std::ofstream(capture_.list()) << "file,x,y,z\n" << rows;
  }

  TestCapture capture_;
};

TEST_F(BuildLfTest, PacksInspectsAndVerifies) {
  capture_.write_distance_map(2, {32, 16});
  const CommandResult packed =
      build_lf("pack --frames " + capture_.root().string() + " --out " + capture_.room().string() +
               " --distance " + capture_.distances().string());  // the folder of the list
  EXPECT_EQ(packed.exit_code, 0) << packed.errors;
  EXPECT_THAT(packed.output, HasSubstr("4 lines, 1 cell, 28 panoramas of 64 x 32, 1 distance map"));
  EXPECT_THAT(packed.errors, HasSubstr("its positions are taken as listed"));
  const CommandResult info = build_lf("info --json " + capture_.room().string());
  EXPECT_EQ(info.exit_code, 0);
  const auto json = nlohmann::json::parse(info.output);
  EXPECT_EQ(json["lines"].size(), 4U);
  EXPECT_EQ(json["cells"].size(), 1U);
  EXPECT_EQ(json["stations"], 28);
  EXPECT_NEAR(json["lines"][0]["overhang_first_m"], 0.25, 1e-12);
  EXPECT_THAT(build_lf("info " + capture_.room().string()).output, HasSubstr("0.250 / 0.250"));
  const CommandResult verified = build_lf("verify " + capture_.room().string());
  EXPECT_EQ(verified.exit_code, 0);
  EXPECT_THAT(verified.output, AllOf(HasSubstr("28 panoramas and 1 distance maps match"),
                                     HasSubstr("distances in use: given")));
}

TEST_F(BuildLfTest, ARoomWithSwappedOrMissingDistancesIsRefused) {
  for (int frame = 0; frame < TestCapture::kStations; ++frame) {
    capture_.write_distance_map(frame, {32, 16});
  }
  ASSERT_EQ(build_lf(pack_arguments() + " --distance " + capture_.distances().string()).exit_code,
            0);
  const std::string room = capture_.room().string();
  const fs::path distances = capture_.room() / "distances" / "given";
  EXPECT_THAT(build_lf("distances " + room).output, HasSubstr("views use the given distances"));
  fs::rename(distances / "x0.h5", distances / "q");
  fs::rename(distances / "x1.h5", distances / "x0.h5");
  fs::rename(distances / "q", distances / "x1.h5");
  expect_error(build_lf("verify " + room), 1, "x0.h5: holds the distances of line x1");
  fs::remove(distances / "x0.h5");
  fs::rename(distances / "x1.h5", distances / "x0.h5");
  expect_error(build_lf("info " + room), 1, "x1.h5: no such file");
  EXPECT_THAT(build_lf("distances " + room).output, HasSubstr("not usable"));
  expect_error(build_lf("distances " + room + " --use estimated"), 1, "raywalk-build-lf depth");
  expect_error(build_lf("distances " + room + " --use both"), 2, "give given or estimated");
  expect_error(build_lf("distances " + room + "/lines"), 1, "not a room");
}

TEST_F(BuildLfTest, ARefinedRoomSaysWhatItWasMadeFrom) {
  for (int frame = 0; frame < TestCapture::kStations; frame += 2) {
    capture_.write_distance_map(frame, {32, 16});
  }
  const std::string room = capture_.room().string();
  const CommandResult before = build_lf("refine " + room);
  expect_error(before, 1, "room.lf");
  ASSERT_EQ(build_lf(pack_arguments() + " --distance " + capture_.distances().string()).exit_code,
            0);
  const CommandResult refined = build_lf("refine " + room + " --compress jpeg:95");
  EXPECT_EQ(refined.exit_code, 0) << refined.errors;
  EXPECT_THAT(refined.output, AllOf(HasSubstr("panoramas of 128 x 64"), HasSubstr("jpeg:95")));
  const fs::path out = capture_.room().parent_path() / "room-refined.lf";
  EXPECT_THAT(build_lf("info " + out.string()).output,
              HasSubstr("developed from 28 photographs of ../room.lf"));
  EXPECT_THAT(build_lf("verify " + out.string()).output, Not(HasSubstr("changed")));
  fs::remove_all(capture_.room());
  EXPECT_THAT(build_lf("verify " + out.string()).output, HasSubstr("whether that has changed"));
  expect_error(build_lf("refine " + room + " --out " + room + "-2"), 1, room);
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

TEST_F(BuildLfTest, HelpAndVersionSucceedAndExamplesAreGiven) {
  for (const char* command : {"", "pack", "info", "verify"}) {
    const CommandResult help = build_lf(std::string(command) + " --help");
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.output, HasSubstr("Example:\n  raywalk-build-lf")) << command;
  }
  EXPECT_THAT(build_lf("--version").output, HasSubstr("raywalk-build-lf "));
}

TEST_F(BuildLfTest, WrongUsageIsExitCodeTwo) {
  expect_error(build_lf(""), 2, "subcommand");
  expect_error(build_lf("pack --out room.lf"), 2, "--frames");
  expect_error(build_lf(pack_arguments() + " --line-tolerance-mm -1"), 2, "--line-tolerance-mm");
  expect_error(build_lf("info --yaml room.lf"), 2, "--yaml");
}

TEST_F(BuildLfTest, PackingOverARoomIsRefused) {
  ASSERT_EQ(build_lf(pack_arguments()).exit_code, 0);
  expect_error(build_lf(pack_arguments()), 1, "exists already");
}

TEST_F(BuildLfTest, BadInputGivesOneErrorLineAndLeavesNothing) {
  fs::resize_file(capture_.path(7), 100);
  expect_clean_pack_error("back_0.png");
  capture_.write_frame(7, {32, 16});
  expect_clean_pack_error("all frames must have one size");
  capture_.write_frame(7, {64, 31});
  expect_clean_pack_error("back_0.png");
  capture_.write_frame(7, {64, 32});
  replace_list("front_0.png,0,0,0\nfront_1.png,nan,0,0\n");
  expect_clean_pack_error("poses.csv:3");
  replace_list("front_0.png,0,0,0\nfront_1.png,0.1,0,0\nfront_2.png,0.1,0,0\n");
  expect_clean_pack_error("poses.csv:4) have the same position");
  replace_list("front_0.png,0,0,0\n");
  expect_clean_pack_error("at least two");
  replace_list("");
  expect_clean_pack_error("no frames");
  fs::remove(capture_.list());
  expect_clean_pack_error("poses.csv");
}

TEST_F(BuildLfTest, DamagedRoomsAreNamed) {
  ASSERT_EQ(build_lf(pack_arguments()).exit_code, 0);
  const fs::path volume = line_volume_path(capture_.room(), "z0");
  const std::string whole = read_file(volume);
  std::string flipped = whole;
  flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 4);
  write_file_atomically(volume, flipped);
  expect_error(build_lf("verify " + capture_.room().string()), 1, "line z0 station 3 (left_3.png)");
  fs::resize_file(volume, whole.size() - 1);
  for (const char* command : {"info ", "verify "}) {
    expect_error(build_lf(command + capture_.room().string()), 1, "z0.h5");
  }
  write_file_atomically(volume, whole);
  std::string manifest = read_file(manifest_path(capture_.room()));
  const std::string version = "\"format_version\": 3";
  manifest.replace(manifest.find(version), version.size(), "\"format_version\": 4");
  write_file_atomically(manifest_path(capture_.room()), manifest);
  expect_error(build_lf("info " + capture_.room().string()), 1, "newer");
}

TEST_F(BuildLfTest, UnwritableOutputIsNamed) {
  // A file in place of a directory is an error even for root.
  const std::string frames = "pack --frames " + capture_.list().string();
  expect_error(build_lf(frames + " --out " + (capture_.list() / "room.lf").string()), 1,
               "poses.csv/room.lf");
  expect_error(build_lf(frames + " --out /proc/room.lf"), 1, "/proc/room.lf");
}

// A file size limit simulates a full disk: writes fail in the same way.
TEST_F(BuildLfTest, FullDiskLeavesNothing) {
  for (int blocks : {0, 1, 4, 16, 41, 82}) {  // of 512 bytes
    // Through a pipe, as the log file must not hit the limit.
    const CommandResult result = run_command(fmt::format(
        "(ulimit -f {}; {} {} 2>&1) | cat >&2", blocks, RAYWALK_BUILD_LF, pack_arguments()));
    EXPECT_EQ(result.errors.find("HDF5-DIAG"), std::string::npos) << result.errors;
    EXPECT_THAT(result.errors, HasSubstr("error: ")) << blocks;
    // Words of HDF5 that tell a user nothing.
    EXPECT_EQ(result.errors.find("bytes actually written"), std::string::npos) << result.errors;
    EXPECT_EQ(result.errors.find("errno"), std::string::npos) << result.errors;
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
  expect_error(stopped, 1, "x1");
  EXPECT_FALSE(fs::exists(capture_.room()));
  const fs::path finished = line_volume_path(capture_.partial(), "x0");
  ASSERT_TRUE(fs::exists(finished));
  const auto written = fs::last_write_time(finished);
  EXPECT_EQ(build_lf(pack_arguments()).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(line_volume_path(capture_.room(), "x0")), written);
  EXPECT_EQ(build_lf("verify " + capture_.room().string()).exit_code, 0);
  EXPECT_FALSE(fs::exists(capture_.partial()));
}

// Packs the embedded room and interrupts as soon as the first volume is finished. Returns the exit
// code, or nothing if the run finished before the signal.
std::optional<int> exit_code_of_interrupted_pack(const fs::path& out) {
  const std::string frames = std::string(RAYWALK_TEST_ROOM) + "/poses.csv";
  const std::string out_text = out.string();
  std::array<const char*, 9> arguments{RAYWALK_BUILD_LF, "pack",  "--frames",
                                       frames.c_str(),   "--out", out_text.c_str(),
                                       "--threads",      "1",     nullptr};
  pid_t child = 0;
  if (posix_spawn(&child, RAYWALK_BUILD_LF, nullptr, nullptr,
                  const_cast<char* const*>(arguments.data()), environ) != 0) {
    return -1;
  }
  const fs::path first = line_volume_path(out.string() + ".partial", "x0");
  int status = 0;
  while (!fs::exists(first) && waitpid(child, &status, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  kill(child, SIGINT);
  waitpid(child, &status, 0);
  if (fs::exists(out)) return std::nullopt;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST_F(BuildLfTest, InterruptedRunKeepsFinishedLinesAndIsResumed) {
  std::optional<int> exit_code;
  for (int attempt = 0; attempt < 5 && !exit_code; ++attempt) {
    fs::remove_all(capture_.room());
    exit_code = exit_code_of_interrupted_pack(capture_.room());
  }
  EXPECT_EQ(exit_code, 130);
  EXPECT_FALSE(fs::exists(capture_.room()));
  const fs::path finished = line_volume_path(capture_.partial(), "x0");
  ASSERT_TRUE(fs::exists(finished));
  const auto written = fs::last_write_time(finished);
  // Resuming with other inputs is refused.
  const CommandResult other = build_lf(pack_arguments());
  expect_error(other, 1, "holds an unfinished room of other frames");
  const CommandResult resumed = build_lf("pack --frames " + std::string(RAYWALK_TEST_ROOM) +
                                         "/poses.csv --out " + capture_.room().string());
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_EQ(fs::last_write_time(line_volume_path(capture_.room(), "x0")), written);
  EXPECT_EQ(build_lf("verify " + capture_.room().string()).exit_code, 0);
}

TEST_F(BuildLfTest, EmbeddedRoomPacksCompletely) {
  const std::string room = RAYWALK_TEST_ROOM;
  const CommandResult packed = build_lf("pack --frames " + room + "/poses.csv --distance " + room +
                                        "/dist --out " + capture_.room().string());
  EXPECT_EQ(packed.exit_code, 0) << packed.errors;
  EXPECT_THAT(packed.output,
              HasSubstr("4 lines, 1 cell, 124 panoramas of 512 x 256, 32 distance maps"));
}

}  // namespace
}  // namespace raywalk::build_lf
