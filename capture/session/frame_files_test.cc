#include "capture/session/frame_files.h"

#include <gmock/gmock.h>

#include <fstream>

#include "capture/session/lossy_disk.h"
#include "capture/session/test_session.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

class FrameFilesTest : public testing::Test {
 protected:
  FrameFilesTest() { files_.make_directory(); }

  TestDirectory directory_;
  FrameFiles files_{directory_.path(), &system_disk()};
};

TEST_F(FrameFilesTest, StoresAFileUnderItsNameAndNothingElse) {
  EXPECT_EQ(files_.store("x0_000.jpg", bytes_of("picture")), "frames/x0_000.jpg");
  EXPECT_EQ(read_file(directory_ / "frames/x0_000.jpg"), "picture");
  EXPECT_THAT(list_frames(directory_.path()), ElementsAre("frames/x0_000.jpg"));
}

TEST_F(FrameFilesTest, NeverOverwritesAFile) {
  files_.store("x0_000.jpg", bytes_of("first"));
  EXPECT_THAT(error_of([&] { files_.store("x0_000.jpg", bytes_of("second")); }),
              AllOf(HasSubstr("frames/x0_000.jpg"), HasSubstr("not overwritten")));
  EXPECT_EQ(read_file(directory_ / "frames/x0_000.jpg"), "first");
  EXPECT_EQ(list_frames(directory_.path()).size(), 1U);
}

TEST_F(FrameFilesTest, DoesNotReplaceASymbolicLinkEither) {
  std::filesystem::create_symlink("elsewhere.jpg", directory_ / "frames/x0_000.jpg");
  EXPECT_THROW(files_.store("x0_000.jpg", bytes_of("picture")), Error);
  EXPECT_TRUE(std::filesystem::is_symlink(directory_ / "frames/x0_000.jpg"));
}

TEST_F(FrameFilesTest, RemovesOnlyTheTemporaryFilesOfAKilledRun) {
  files_.store("x0_000.jpg", bytes_of("picture"));
  std::ofstream(directory_ / "frames/.x0_001.jpg.partial") << "pict";
  std::ofstream(directory_ / "frames/notes.txt") << "mine";
  files_.remove_temporaries();
  EXPECT_THAT(list_frames(directory_.path()), ElementsAre("frames/notes.txt", "frames/x0_000.jpg"));
}

TEST_F(FrameFilesTest, NamesTheFileWhereTheDirectoryIsGone) {
  std::filesystem::remove(directory_ / "frames");
  EXPECT_THAT(error_of([&] { files_.store("x0_000.jpg", bytes_of("picture")); }),
              AllOf(HasSubstr("cannot write"), HasSubstr("x0_000.jpg"), HasSubstr("No such file")));
}

TEST(FrameFilesOnAFullDiskTest, LeaveNothingWhicheverOperationFails) {
  int failures = 0;
  for (int operation = 0;; ++operation) {
    LossyDisk disk;
    disk.full_at = operation;
    FrameFiles files("/session", &disk);
    const std::string error = error_of([&] { files.store("x0_000.jpg", bytes_of("picture")); });
    if (error.empty()) break;
    ++failures;
    EXPECT_THAT(error, AllOf(HasSubstr("/session/frames/x0_000.jpg"),
                             HasSubstr("No space left on device"), HasSubstr("free some space")));
    EXPECT_THAT(disk.names(), IsEmpty()) << "operation " << operation;
    disk.full_at = -1;
    EXPECT_NO_THROW(files.store("x0_000.jpg", bytes_of("picture"))) << "operation " << operation;
  }
  EXPECT_EQ(failures, 6);  // create, write, sync, close, rename, sync of the directory
}

}  // namespace
}  // namespace raywalk::capture
