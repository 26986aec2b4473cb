// A session survives a kill of the program at any moment.
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <map>
#include <random>

#include "capture/session/session_database.h"
#include "capture/session/session_frames.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using testing::Contains;
using testing::IsEmpty;

constexpr int kKills = 20;
constexpr int kLongestRun_us = 80000;

// Captures in another process, which is killed with SIGKILL after the time given. The manual clock
// of this process is advanced, because it does not share that of the other.
void capture_and_kill(TestCapture* capture, int after_us) {
  capture->clock.sleep(std::chrono::hours(1));
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    try {
      capture->capture_missing(capture->open().get());
    } catch (...) {
      _exit(1);
    }
    _exit(0);
  }
  usleep(static_cast<useconds_t>(after_us));
  kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_FALSE(WIFEXITED(status) && WEXITSTATUS(status) == 1) << "the run failed";
}

std::map<std::string, std::string> whole_files(const std::filesystem::path& directory) {
  std::map<std::string, std::string> files;
  for (const std::string& file : list_frames(directory)) {
    if (!is_temporary_frame(file)) files[file] = read_file(directory / file);
  }
  return files;
}

TEST(KilledSessionTest, IsResumedWithEveryStationOnceAndNoFileOverwritten) {
  const TestDirectory directory;
  TestCapture capture{.directory = directory / "session",
                      .plan = {.lines = {test_line("x0", LineAxis::kX, 0.0, 0.0, 0.01, 40)}}};
  std::mt19937 random(3);
  std::map<std::string, std::string> before;
  for (int i = 0; i < kKills; ++i) {
    capture_and_kill(&capture, static_cast<int>(random() % kLongestRun_us));
    const std::map<std::string, std::string> after = whole_files(capture.directory);
    for (const auto& file : before) EXPECT_THAT(after, Contains(file)) << "kill " << i;
    before = after;
  }
  capture.clock.sleep(std::chrono::hours(1));
  capture.capture_missing(capture.open().get());
  SessionReader reader(capture.directory);
  EXPECT_THAT(verify_session(&reader).faults, IsEmpty());
  std::set<std::string> stations;
  const SessionContents contents = reader.contents();
  for (const SessionFrame& frame : contents.frames) {
    const std::string& station = contents.station_of(frame).name;
    EXPECT_TRUE(stations.insert(station).second) << station;
  }
  EXPECT_EQ(stations.size(), 40U);
}

}  // namespace
}  // namespace raywalk::capture
