// A frame is on the disk before the row that names it, and a full disk leaves nothing half. That a
// session survives kills at any moment is tested with the whole program (tests/end_to_end).
//
// The functions below stand in for those of the C library, in this program and in SQLite.
#include <gmock/gmock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/session/session_frames.h"
#include "capture/session/test_session.h"

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
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
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

}  // namespace
}  // namespace raywalk::capture
