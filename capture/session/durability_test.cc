// A frame is on the disk before the row that names it, a full disk leaves nothing half, and a
// session survives a kill of the program at any moment.
//
// The functions below stand in for those of the C library, in this program and in SQLite.
#include <gmock/gmock.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "capture/session/session_frames.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"

namespace {

std::vector<std::string> synced;  // what was synced, in order; of a folder with what it holds
int full_at = -1;                 // the sync, from 0, at which the disk is full; -1: never

int record_sync(int descriptor, int call) {
  namespace fs = std::filesystem;
  const fs::path path = fs::read_symlink("/proc/self/fd/" + std::to_string(descriptor));
  std::string text = path.filename().string();
  if (text == "frames") {
    for (const auto& entry : fs::directory_iterator(path)) {
      text += " " + entry.path().filename().string();
    }
  }
  synced.push_back(text);
  if (full_at == static_cast<int>(synced.size()) - 1) {
    errno = ENOSPC;
    return -1;
  }
  return static_cast<int>(syscall(call, descriptor));
}

}  // namespace

extern "C" int fsync(int descriptor) { return record_sync(descriptor, SYS_fsync); }
extern "C" int fdatasync(int descriptor) { return record_sync(descriptor, SYS_fdatasync); }

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class DurabilityTest : public SessionCase {
 protected:
  // Captures a station whose sync number `fails` finds the disk full; -1: none does.
  std::string capture(std::size_t station, int fails = -1) {
    synced.clear();
    full_at = fails;
    const std::string error = error_of(
        [&] { capture_.capture(session_.get(), capture_.plan.lines[0].stations[station]); });
    full_at = -1;
    return error;
  }

  std::unique_ptr<Session> session_ = capture_.open();
};

TEST_F(DurabilityTest, TheAttemptThenTheFrameThenItsNameThenItsRow) {
  EXPECT_EQ(capture(0), "no error");
  EXPECT_THAT(synced,
              ElementsAre("session.db-wal", AllOf(StartsWith(".x0_000."), EndsWith(".partial.jpg")),
                          "frames x0_000.jpg", "session.db-wal"));
}

TEST_F(DurabilityTest, AFullDiskDuringAFrameLosesNothing) {
  capture(0);
  EXPECT_THAT(capture(1, 1), AllOf(HasSubstr("x0_001.jpg"), HasSubstr("free some space")));
  EXPECT_THAT(capture(1, 2), AllOf(HasSubstr("x0_001_a2.jpg"), HasSubstr("free some space")));
  EXPECT_THAT(list_frames(capture_.directory), ElementsAre("frames/x0_000.jpg"));
  capture_.capture_missing(session_.get());
  EXPECT_THAT(list_frames(capture_.directory),
              ElementsAre("frames/x0_000.jpg", "frames/x0_001_a3.jpg", "frames/x0_002.jpg"));
  SessionReader reader(capture_.directory);
  EXPECT_TRUE(verify_session(&reader).is_whole());
}

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
  constexpr int kKills = 20;
  constexpr int kLongestRun_us = 80000;
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
  const SessionVerification verification = verify_session(&reader);
  EXPECT_THAT(verification.faults, IsEmpty());
  EXPECT_EQ(verification.frames, 40);
}

}  // namespace
}  // namespace raywalk::capture
