#include "core/files/file_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

TEST(FileLockTest, IsHeldByOneAtATime) {
  const TestDirectory directory;
  const auto take = [&] { FileLock(directory / "lock", "busy; wait for it"); };
  {
    const FileLock held(directory / "lock", "busy");
    EXPECT_THAT(take, ThrowsMessage<Error>(directory.path().string() + ": busy; wait for it"));
    EXPECT_NO_THROW(FileLock(directory / "other", "busy"));
  }
  EXPECT_NO_THROW(take()) << "released with the object";
}

TEST(FileLockTest, IsSharedOnceTheFirstHasPreparedTheFolder) {
  const TestDirectory directory;
  const auto shared = [&] {
    return std::make_unique<FileLock>(directory / "lock", "busy", FileLock::Use::kShared);
  };
  const auto first = shared();
  EXPECT_TRUE(first->alone());
  std::atomic<bool> prepared = false;
  std::thread second([&] {
    const auto lock = shared();
    EXPECT_TRUE(prepared) << "shared while it was held alone";
    EXPECT_FALSE(lock->alone());
    EXPECT_FALSE(lock->try_alone());
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  prepared = true;
  first->share();
  second.join();
  EXPECT_FALSE(first->alone());
  EXPECT_FALSE(shared()->alone());
  EXPECT_THROW(FileLock(directory / "lock", "busy"), Error) << "alone while others share it";
  EXPECT_TRUE(first->try_alone()) << "the others have gone";
}

// A new file of the same name, created after the holder removed the old one, is not locked.
TEST(FileLockTest, LocksTheFileNotItsName) {
  const TestDirectory directory;
  const FileLock held(directory / "lock", "busy");
  std::filesystem::rename(directory / "lock", directory / "elsewhere");
  EXPECT_NO_THROW(FileLock(directory / "lock", "busy"));
  EXPECT_THROW(FileLock(directory / "elsewhere", "busy"), Error);
}

TEST(FileLockTest, UnwritableDirectoryIsNotReportedAsBusy) {
  const TestDirectory directory;
  EXPECT_THAT([&] { FileLock(directory / "missing/lock", "busy"); },
              ThrowsMessage<Error>(
                  AllOf(HasSubstr("cannot write"), HasSubstr("missing"), Not(HasSubstr("busy")))));
  std::filesystem::create_directory(directory / "lock");
  EXPECT_THAT([&] { FileLock(directory / "lock", "busy"); },
              ThrowsMessage<Error>(HasSubstr("cannot write")));
}

}  // namespace
}  // namespace raywalk
