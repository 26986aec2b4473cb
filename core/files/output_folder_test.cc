#include "core/files/output_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/file_lock.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

TEST(OutputFolderTest, RemovesATrailingSlash) {
  EXPECT_EQ(without_trailing_slash("a/room.lf/"), "a/room.lf");
  EXPECT_EQ(without_trailing_slash("a/room.lf"), "a/room.lf");
  EXPECT_EQ(without_trailing_slash(""), "");
}

TEST(OutputFolderTest, ExistingPathIsAnErrorNamingPathAndOption) {
  const TestDirectory directory;
  EXPECT_NO_THROW(require_absent(directory / "free", "--out"));
  std::filesystem::create_directory(directory / "taken");
  std::filesystem::create_symlink(directory / "nowhere", directory / "link");
  for (const char* name : {"taken", "link"}) {
    EXPECT_THAT([&] { require_absent(directory / name, "--thin"); },
                ::testing::ThrowsMessage<Error>((directory / name).string() +
                                                ": exists already; choose another --thin, or "
                                                "replace it with --force"));
  }
}

const OwnOutput kAlbum{"an album", "album.json", "raywalk-album",
                       [](const std::filesystem::path& relative, bool is_directory) {
                         return is_directory || relative.extension() == ".json" ||
                                relative.extension() == ".h5";
                       }};

class ReplacingTest : public ::testing::Test {
 protected:
  // An album with one volume.
  std::filesystem::path make_album(const std::string& name, const std::string& volume) const {
    std::filesystem::create_directories(directory_ / name / "lines");
    write_file_atomically(directory_ / name / "album.json", "{\"format\": \"raywalk-album\"}");
    write_file_atomically(directory_ / name / "lines" / "x0.h5", volume);
    return directory_ / name;
  }
  std::string refusal(const std::filesystem::path& path) const {
    return error_of([&] { require_replaceable(path, kAlbum); });
  }

  TestDirectory directory_;
};

TEST_F(ReplacingTest, OwnOutputAndNothingMayBeReplaced) {
  EXPECT_EQ(refusal(make_album("album", "old")), "no error");
  EXPECT_EQ(refusal(directory_ / "absent"), "no error");
  std::filesystem::create_directory(directory_ / "empty");
  EXPECT_EQ(refusal(directory_ / "empty"), "no error");
}

TEST_F(ReplacingTest, WhatIsNotRaywalksOwnMayNot) {
  using ::testing::HasSubstr;
  std::filesystem::create_directory(directory_ / "photos");
  write_file_atomically(directory_ / "photos" / "a.jpg", "picture");
  EXPECT_THAT(refusal(directory_ / "photos"), HasSubstr("holds no album.json"));
  write_file_atomically(directory_ / "photos" / "album.json", "{\"name\": \"my web page\"}");
  EXPECT_THAT(refusal(directory_ / "photos"), HasSubstr("holds no album.json that Raywalk wrote"));

  const auto album = make_album("album", "old");
  write_file_atomically(album / "lines" / "notes.txt", "mine");
  EXPECT_THAT(refusal(album), HasSubstr("lines/notes.txt, which is not part of an album"));
  std::filesystem::remove(album / "lines" / "notes.txt");
  std::filesystem::create_symlink("/etc", album / "etc.json");
  EXPECT_THAT(refusal(album), HasSubstr("etc.json"));
  std::filesystem::create_directory_symlink(album, directory_ / "link");
  EXPECT_THAT(refusal(directory_ / "link"), HasSubstr("it is a symbolic link"));
  write_file_atomically(directory_ / "file", "text");
  EXPECT_THAT(refusal(directory_ / "file"), HasSubstr("it is a file"));
}

TEST_F(ReplacingTest, AReplacedDirectoryIsGoneAndTheNewOneWhole) {
  const auto album = make_album("album", "old");
  write_file_atomically(album / "lines" / "x1.h5", "only in the old one");
  move_into_place(make_album("new", "new"), album);
  EXPECT_EQ(read_file(album / "lines" / "x0.h5"), "new");
  EXPECT_FALSE(std::filesystem::exists(album / "lines" / "x1.h5"));
  EXPECT_EQ(directory_.entries(), 1U);
}

TEST_F(ReplacingTest, AnOutputFolderAppearsWhenItIsComplete) {
  const std::filesystem::path out = directory_ / "albums" / "new";
  {
    OutputFolder stopped(out, false, kAlbum);
    write_file_atomically(stopped.directory() / "half.h5", "half");
  }
  EXPECT_TRUE(std::filesystem::is_empty(directory_ / "albums"));
  for (const std::string content : {"first", "second"}) {
    OutputFolder folder(out.string() + "/", content == "second", kAlbum);
    write_file_atomically(folder.directory() / "album.json", "\"raywalk-album\" " + content);
    folder.complete();
    EXPECT_EQ(read_file(out / "album.json"), "\"raywalk-album\" " + content);
  }
  EXPECT_THAT(error_of([&] { OutputFolder(out, false, kAlbum); }),
              ::testing::HasSubstr("exists already"));
}

TEST_F(ReplacingTest, WhatAppearsMeanwhileIsNotReplaced) {
  OutputFolder folder(directory_ / "album", true, kAlbum);
  std::filesystem::create_directory(directory_ / "album");
  write_file_atomically(directory_ / "album" / "mine.txt", "mine");
  EXPECT_THAT(error_of([&] { folder.complete(); }), ::testing::HasSubstr("holds no album.json"));
  EXPECT_EQ(read_file(directory_ / "album" / "mine.txt"), "mine");
}

TEST_F(ReplacingTest, OnlyASignedFileMayBeReplaced) {
  const std::filesystem::path file = directory_ / "a.ply";
  const auto check = [&] { require_replaceable_file(file, "an export", "comment raywalk"); };
  EXPECT_NO_THROW(check());
  write_file_atomically(file, "ply\ncomment raywalk\n");
  EXPECT_NO_THROW(check());
  write_file_atomically(file, "ply\n");
  EXPECT_THAT(error_of(check), ::testing::HasSubstr("it is not an export of Raywalk's"));
}

TEST_F(ReplacingTest, BytesAreThoseOfFilesAtAnyDepth) {
  EXPECT_EQ(bytes_in(make_album("album", "12345")), 5U + 27U);
  EXPECT_EQ(bytes_in(directory_ / "missing"), 0U);
}

TEST_F(ReplacingTest, WhatCannotBeReplacedIsKept) {
  const auto album = make_album("album", "old");
  EXPECT_NE(error_of([&] { move_into_place(directory_ / "absent", album); }), "no error");
  EXPECT_EQ(read_file(album / "lines" / "x0.h5"), "old");
}

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
