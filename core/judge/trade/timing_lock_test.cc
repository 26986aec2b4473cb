#include "core/judge/trade/timing_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;

// Locks of two descriptors exclude each other also within a process (flock(2)).
TEST(TimingLock, WaitsForTheOtherAndSaysWhoItIs) {
  const TestDirectory directory;
  std::optional<TimingLock> first(std::in_place, directory / "lock", "trade a.lf");
  EXPECT_EQ(read_file(directory / "lock"), "process " + std::to_string(getpid()) + " (trade a.lf)");
  int pauses = 0;
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  const TimingLock second(directory / "lock", "trade b.lf", [&] {
    if (++pauses == 3) first.reset();
  });
  const std::string said =
      ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(pauses, 3);
  EXPECT_THAT(said, HasSubstr("(trade a.lf) is timing views on this machine; waiting"));
  EXPECT_EQ(said.find("is timing"), said.rfind("is timing")) << "said once";
  EXPECT_THAT(read_file(directory / "lock"), HasSubstr("(trade b.lf)"));
}

TEST(TimingLock, AFreeLockIsTakenAtOnce) {
  const TestDirectory directory;
  { const TimingLock first(directory / "lock", "a"); }
  const TimingLock second(directory / "lock", "b", [] { FAIL() << "nobody holds it"; });
}

TEST(TimingLock, WaitingEndsWhereThePauseThrows) {
  const TestDirectory directory;
  const TimingLock first(directory / "lock", "a");
  EXPECT_THROW(TimingLock(directory / "lock", "b", [] { throw Interrupted("stop"); }), Interrupted);
}

TEST(TimingLock, AFileThatCannotBeLockedIsNamed) {
  const TestDirectory directory;
  try {
    const TimingLock lock(directory / "none" / "lock", "a");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot open " + (directory / "none" / "lock").string()));
  }
}

}  // namespace
}  // namespace raywalk
