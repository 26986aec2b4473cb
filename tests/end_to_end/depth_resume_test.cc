// End-to-end test of interrupting and resuming raywalk-build-lf depth.
#include <gmock/gmock.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <array>
#include <chrono>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "core/room/hdf5_file.h"
#include "tests/end_to_end/depth_command.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// Checksums of the maps of each line.
std::vector<std::vector<std::string>> maps_of(const fs::path& room) {
  std::vector<std::vector<std::string>> lines;
  for (const char* line : {"x0", "x1", "z0", "z1"}) {
    lines.push_back(Hdf5File::open(distance_volume_path(room, line, DistanceKind::kEstimated))
                        .read_strings("sha256"));
  }
  return lines;
}

size_t swept_maps(const fs::path& room) {
  std::error_code error;
  size_t count = 0;
  for (const auto& entry : fs::directory_iterator(room / "distances.partial", error)) {
    if (entry.path().filename().string().starts_with("swept-")) ++count;
  }
  return count;
}

// Runs the program and interrupts it when `maps` maps have been swept.
int exit_code_of_interrupted(const fs::path& room, size_t maps) {
  const std::string text = room.string();
  const std::array<const char*, 6> arguments{RAYWALK_BUILD_LF, "depth", text.c_str(),
                                             "--threads",      "1",     nullptr};
  pid_t child = 0;
  if (posix_spawn(&child, RAYWALK_BUILD_LF, nullptr, nullptr,
                  const_cast<char* const*>(arguments.data()), environ) != 0) {
    return -1;
  }
  int status = 0;
  while (swept_maps(room) < maps && waitpid(child, &status, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  kill(child, SIGINT);
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::map<fs::path, fs::file_time_type> finished_maps(const fs::path& room) {
  std::map<fs::path, fs::file_time_type> times;
  for (const auto& entry : fs::directory_iterator(room / "distances.partial")) {
    if (entry.path().extension() == ".map") times[entry.path()] = fs::last_write_time(entry.path());
  }
  return times;
}

TEST(DepthCommandTest, CtrlCKeepsFinishedMapsAndTheSameCommandResumes) {
  const SyntheticRoomSpec spec = furnished_room(128);
  DepthTestRoom room(spec);
  room.give_distances(spec.scene, {64, 32}, 8);
  const fs::path directory = room.room().directory();
  const auto given = files_in(directory / "distances/given");
  EXPECT_EQ(exit_code_of_interrupted(directory, 2), 130);
  const auto first = finished_maps(directory);
  EXPECT_GE(first.size(), 2U);
  EXPECT_EQ(exit_code_of_interrupted(directory, swept_maps(directory) + 2), 130);
  const auto second = finished_maps(directory);
  EXPECT_GT(second.size(), first.size());
  for (const auto& [file, time] : first) EXPECT_EQ(second.at(file), time) << file;
  // The room is unchanged until the command completes.
  EXPECT_EQ(files_in(directory / "distances/given"), given);
  EXPECT_FALSE(fs::exists(directory / "depth.json"));

  const CommandResult resumed = depth(room.room());
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_EQ(files_in(directory / "distances/given"), given);
  EXPECT_FALSE(fs::exists(directory / "distances.partial"));
  // The result of three interrupted runs equals that of a single run.
  const auto in_parts = maps_of(directory);
  ASSERT_EQ(depth(room.room()).exit_code, 0);
  EXPECT_EQ(maps_of(directory), in_parts);
}

}  // namespace
}  // namespace raywalk::build_lf
