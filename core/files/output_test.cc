// Files and folders that appear when they are complete, and how files are read.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/file_lock.h"
#include "core/files/output_folder.h"
#include "core/files/test_support.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(AtomicFile, TargetAppearsOnlyWithCommit) {
  const TestDirectory directory;
  const fs::path target = directory / "view.png";
  AtomicFile output(target);
  EXPECT_EQ(output.temporary_path().parent_path(), directory.path());
  EXPECT_EQ(output.temporary_path().extension(), ".png");
  EXPECT_TRUE(output.temporary_path().filename().string().starts_with("."));
  EXPECT_NE(AtomicFile(target).temporary_path(), output.temporary_path());
  std::ofstream(output.temporary_path()) << "picture";
  EXPECT_FALSE(fs::exists(target));
  output.commit();
  EXPECT_EQ(read_file(target), "picture");
  EXPECT_EQ(directory.entries(), 1U);
}

TEST(AtomicFile, WithoutCommitTheOldContentStaysAndNothingElse) {
  const TestDirectory directory;
  write_file_atomically(directory / "a.txt", "old");
  {
    const AtomicFile output(directory / "a.txt");
    std::ofstream(output.temporary_path()) << "half of the n";
  }
  EXPECT_EQ(read_file(directory / "a.txt"), "old");
  EXPECT_EQ(directory.entries(), 1U);
  AtomicFile unwritten(directory / "a.txt");
  EXPECT_THAT(error_of([&] { unwritten.commit(); }), HasSubstr("a.txt: No such file"));
}

TEST(WriteNewFile, NeverOverwritesAFileOrALink) {
  const TestDirectory directory;
  const auto write = [&](const std::string& name, const std::string& text) {
    write_new_file(directory / name, std::as_bytes(std::span(text)));
  };
  write("a.jpg", "first");
  fs::create_symlink("elsewhere.jpg", directory / "b.jpg");
  for (const char* name : {"a.jpg", "b.jpg"}) {
    EXPECT_THAT(error_of([&] { write(name, "second"); }),
                AllOf(HasSubstr(name), HasSubstr("already exists and is not overwritten")));
  }
  EXPECT_EQ(read_file(directory / "a.jpg"), "first");
  EXPECT_TRUE(fs::is_symlink(directory / "b.jpg"));
  EXPECT_EQ(directory.entries(), 2U);
  EXPECT_THAT(error_of([&] { write("gone/c.jpg", "picture"); }),
              AllOf(HasSubstr("cannot write"), HasSubstr("c.jpg"), HasSubstr("No such file")));
}

TEST(AtomicFile, InvalidTargetsAreRejectedBeforeWriting) {
  const TestDirectory directory;
  fs::create_directory(directory / "folder");
  write_file_atomically(directory / "file", "text");
  EXPECT_THAT(error_of([&] { AtomicFile(directory / "folder"); }), HasSubstr("is a directory"));
  EXPECT_THAT(error_of([&] { AtomicFile(directory / "missing/a.png"); }),
              AllOf(HasSubstr("missing/a.png"), HasSubstr("create it first")));
  EXPECT_THAT(error_of([&] { AtomicFile(directory / "file/a.png"); }),
              HasSubstr("not an existing directory"));
  EXPECT_THAT(error_of([] { AtomicFile(""); }), HasSubstr("names no file"));
  EXPECT_THAT(error_of([] { AtomicFile("/dev/null"); }), HasSubstr("not a regular file"));
  EXPECT_THAT(error_of([] { write_file_atomically("/proc/raywalk", "text"); }),
              HasSubstr("cannot write /proc/raywalk: "));
  EXPECT_THAT(error_of([&] { make_directories(directory / "file" / "a"); }), HasSubstr("file/a"));
}

TEST(AtomicFile, SymbolicLinkStaysAndItsFileIsReplacedAndNamesMayBeLong) {
  const TestDirectory directory;
  const fs::path longest = directory / (std::string(251, 'x') + ".txt");
  write_file_atomically(longest, "text");
  EXPECT_EQ(read_file(longest), "text");
  fs::create_directory(directory / "disk");
  write_file_atomically(directory / "disk/real.txt", "old");
  fs::create_symlink("disk/real.txt", directory / "link.txt");
  write_file_atomically(directory / "link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(directory / "link.txt"));
  EXPECT_EQ(read_file(directory / "disk/real.txt"), "new");
}

// A file-size limit makes write(2) fail part-way, as a full disk does.
void write_beyond_limit(const fs::path& target) {
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit = {4096, 4096};
  setrlimit(RLIMIT_FSIZE, &limit);
  const std::string message =
      error_of([&] { write_file_atomically(target, std::string(100000, 'x')); });
  const bool named = message == "cannot write " + target.string() + ": File too large";
  std::_Exit(named ? 42 : 1);
}

TEST(WriteFileDeathTest, FailedWriteNamesFileAndReasonAndKeepsTheOldFile) {
  const TestDirectory directory;
  write_file_atomically(directory / "rays.bin", "old");
  EXPECT_EXIT(write_beyond_limit(directory / "rays.bin"), testing::ExitedWithCode(42), "");
  EXPECT_EQ(read_file(directory / "rays.bin"), "old");
  EXPECT_EQ(directory.entries(), 1U);
}

// What a process leaves that writes to `target` and is killed.
void die_while_writing(const fs::path& target, const std::function<void(fs::path)>& write) {
  const pid_t child = fork();
  if (child == 0) {
    write(temporary_beside(target));
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
}

void write_text(const fs::path& file) { std::ofstream(file) << "half"; }

void write_tree(const fs::path& directory) {
  fs::create_directories(directory / "truth");
  write_text(directory / "truth" / "a.png");
}

TEST(TemporaryNames, WhatAKilledProcessLeftIsRemovedByTheNext) {
  const TestDirectory directory;
  die_while_writing(directory / "view.png", write_text);
  EXPECT_EQ(directory.entries(), 1U);
  die_while_writing(directory / "room", write_tree);
  EXPECT_EQ(directory.entries(), 1U) << "a process removed the picture and left its own";
  write_file_atomically(directory / "other.txt", "text");
  EXPECT_EQ(directory.entries(), 1U);
  EXPECT_TRUE(fs::exists(directory / "other.txt"));
}

TEST(TemporaryNames, WhatARunningProcessWritesStays) {
  const TestDirectory directory;
  const fs::path ours = temporary_beside(directory / "view.png");
  write_text(ours);
  die_while_writing(directory / "other.txt", [](const fs::path&) {});
  EXPECT_TRUE(fs::exists(ours));
  write_file_atomically(directory / "third.txt", "text");
  EXPECT_TRUE(fs::exists(ours));
}

TEST(TemporaryNames, ThoseOfAnotherSystemStayForADayAndOtherFilesForEver) {
  const TestDirectory directory;
  const auto old = [&](const std::string& name) {
    write_text(directory / name);
    fs::last_write_time(directory / name,
                        fs::file_time_type::clock::now() - std::chrono::hours(25));
  };
  for (const char* name : {"room.lf.partial", ".hidden", ".a.partial", "a.12345678-1.0.partial.png",
                           ".x0_007.jpg.partial", "trade.partial.json"}) {
    old(name);
  }
  old(".old.00000000-1.0.partial.png");
  write_text(directory / ".new.00000000-1.0.partial.png");
  temporary_beside(directory / "view.png");
  EXPECT_FALSE(fs::exists(directory / ".old.00000000-1.0.partial.png"));
  EXPECT_EQ(directory.entries(), 7U);
}

TEST(ReadFile, ReturnsAllBytesAsTheyAre) {
  const TestDirectory directory;
  std::string bytes;
  for (int i = 0; i < 3000000; ++i) bytes += static_cast<char>(i * 7);
  write_file_atomically(directory / "a", bytes);
  EXPECT_EQ(read_file(directory / "a"), bytes);
  EXPECT_EQ(read_file_prefix(directory / "a", 1000), bytes.substr(0, 1000));
  EXPECT_EQ(read_file_prefix(directory / "a", 1U << 30), bytes);
  write_file_atomically(directory / "empty", "");
  EXPECT_EQ(read_file(directory / "empty"), "");
  EXPECT_NE(read_file("/proc/self/status"), "") << "a file without a size";
  EXPECT_EQ(read_file(directory / "a", bytes.size()), bytes);
  EXPECT_THAT(error_of([&] { read_file(directory / "a", 4); }), HasSubstr("larger than 4 bytes"));
}

TEST(ReadFile, OnlyRegularFilesAreRead) {
  const TestDirectory directory;
  const fs::path pipe = directory / "pipe", link = directory / "link",
                 socket = directory / "socket";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0666), 0);
  ASSERT_EQ(mknod(socket.c_str(), S_IFSOCK | 0666, 0), 0);
  fs::create_symlink("pipe", link);
  for (const fs::path& file : {pipe, link}) {
    EXPECT_THAT(error_of([&] { read_file(file); }),
                AllOf(HasSubstr(file.string()), HasSubstr("Is a named pipe"),
                      HasSubstr("give a regular file")));
    EXPECT_THAT(error_of([&] { read_file_prefix(file, 10); }), HasSubstr("named pipe"));
  }
  EXPECT_THAT(error_of([&] { read_file(socket); }), HasSubstr("socket or device"));
  EXPECT_THAT(error_of([] { read_file("/dev/zero"); }),
              HasSubstr("/dev/zero: Is a named pipe, socket or device"));
  EXPECT_THAT(error_of([&] { read_file(directory / "none.csv"); }),
              HasSubstr("none.csv: No such file or directory"));
  EXPECT_THAT(error_of([&] { read_file(directory.path()); }),
              AllOf(HasSubstr(directory.path().string()), HasSubstr("Is a directory")));
  write_file_atomically(directory / "a", "text");
  fs::create_symlink("a", directory / "linked");
  EXPECT_EQ(read_file(directory / "linked"), "text");
}

TEST(ReadFileDeathTest, DashIsStandardInput) {
  EXPECT_EXIT(
      {
        int ends[2];
        if (pipe(ends) != 0 || write(ends[1], "list", 4) != 4) std::_Exit(1);
        dup2(ends[0], STDIN_FILENO);
        close(ends[1]);
        const bool same = read_file_or_stdin("-") == "list" && input_name("-") == "standard input";
        std::_Exit(same ? 42 : 2);
      },
      testing::ExitedWithCode(42), "");
}

TEST(OutputFolderTest, ExistingPathIsAnErrorNamingPathAndOption) {
  const TestDirectory directory;
  EXPECT_NO_THROW(require_absent(directory / "free", "--out"));
  fs::create_directory(directory / "taken");
  fs::create_symlink(directory / "nowhere", directory / "link");
  for (const char* name : {"taken", "link"}) {
    EXPECT_EQ(error_of([&] { require_absent(directory / name, "--thin"); }),
              (directory / name).string() +
                  ": exists already; choose another --thin, or replace it with --force");
  }
}

const OwnOutput kAlbum{
    "an album", "album.json", "raywalk-album", [](const fs::path& relative, bool is_directory) {
      return is_directory || relative.extension() == ".json" || relative.extension() == ".h5";
    }};

class ReplacingTest : public ::testing::Test {
 protected:
  // An album with one volume.
  fs::path make_album(const std::string& name, const std::string& volume) const {
    fs::create_directories(directory_ / name / "lines");
    write_file_atomically(directory_ / name / "album.json", "{\"format\": \"raywalk-album\"}");
    write_file_atomically(directory_ / name / "lines" / "x0.h5", volume);
    return directory_ / name;
  }
  std::string refusal(const fs::path& path) const {
    return error_of([&] { require_replaceable(path, kAlbum); });
  }

  TestDirectory directory_;
};

TEST_F(ReplacingTest, OwnOutputAndNothingMayBeReplacedWhatIsNotRaywalksOwnMayNot) {
  fs::create_directory(directory_ / "empty");
  for (const fs::path& path :
       {make_album("old", "x"), directory_ / "absent", directory_ / "empty"}) {
    EXPECT_EQ(refusal(path), "no error") << path;
  }
  fs::create_directory(directory_ / "photos");
  write_file_atomically(directory_ / "photos" / "a.jpg", "picture");
  EXPECT_THAT(refusal(directory_ / "photos"), HasSubstr("holds no album.json"));
  write_file_atomically(directory_ / "photos" / "album.json", "{\"name\": \"my web page\"}");
  EXPECT_THAT(refusal(directory_ / "photos"), HasSubstr("holds no album.json that Raywalk wrote"));

  const auto album = make_album("album", "old");
  write_file_atomically(album / "lines" / "notes.txt", "mine");
  EXPECT_THAT(refusal(album), HasSubstr("lines/notes.txt, which is not part of an album"));
  fs::remove(album / "lines" / "notes.txt");
  fs::create_symlink("/etc", album / "etc.json");
  EXPECT_THAT(refusal(album), HasSubstr("etc.json"));
  fs::create_directory_symlink(album, directory_ / "link");
  EXPECT_THAT(refusal(directory_ / "link"), HasSubstr("it is a symbolic link"));
  write_file_atomically(directory_ / "file", "text");
  EXPECT_THAT(refusal(directory_ / "file"), HasSubstr("it is a file"));
}

TEST_F(ReplacingTest, AReplacedDirectoryIsGoneAndTheNewOneWhole) {
  const auto album = make_album("album", "old");
  write_file_atomically(album / "lines" / "x1.h5", "only in the old one");
  move_into_place(make_album("new", "new"), album);
  EXPECT_EQ(read_file(album / "lines" / "x0.h5"), "new");
  EXPECT_FALSE(fs::exists(album / "lines" / "x1.h5"));
  EXPECT_EQ(directory_.entries(), 1U);
}

TEST_F(ReplacingTest, AnOutputFolderAppearsWhenItIsComplete) {
  const fs::path out = directory_ / "albums" / "new";
  {
    OutputFolder stopped(out, false, kAlbum);
    write_file_atomically(stopped.directory() / "half.h5", "half");
  }
  EXPECT_TRUE(fs::is_empty(directory_ / "albums"));
  for (const std::string content : {"first", "second"}) {
    OutputFolder folder(out.string() + "/", content == "second", kAlbum);
    write_file_atomically(folder.directory() / "album.json", "\"raywalk-album\" " + content);
    folder.complete();
    EXPECT_EQ(read_file(out / "album.json"), "\"raywalk-album\" " + content);
  }
  EXPECT_THAT(error_of([&] { OutputFolder(out, false, kAlbum); }), HasSubstr("exists already"));
}

TEST_F(ReplacingTest, WhatAppearsMeanwhileIsNotReplaced) {
  OutputFolder folder(directory_ / "album", true, kAlbum);
  fs::create_directory(directory_ / "album");
  write_file_atomically(directory_ / "album" / "mine.txt", "mine");
  EXPECT_THAT(error_of([&] { folder.complete(); }), HasSubstr("holds no album.json"));
  EXPECT_EQ(read_file(directory_ / "album" / "mine.txt"), "mine");
}

TEST_F(ReplacingTest, OnlyASignedFileMayBeReplaced) {
  const fs::path file = directory_ / "a.ply";
  const auto check = [&] { require_replaceable_file(file, "an export", "comment raywalk"); };
  EXPECT_NO_THROW(check());
  write_file_atomically(file, "ply\ncomment raywalk\n");
  EXPECT_NO_THROW(check());
  write_file_atomically(file, "ply\n");
  EXPECT_THAT(error_of(check), HasSubstr("it is not an export of Raywalk's"));
}

TEST_F(ReplacingTest, WhatCannotBeReplacedIsKept) {
  const auto album = make_album("album", "12345");
  EXPECT_NE(error_of([&] { move_into_place(directory_ / "absent", album); }), "no error");
  EXPECT_EQ(bytes_in(album), 5U + 27U) << "of files at any depth";
  EXPECT_EQ(bytes_in(directory_ / "absent"), 0U);
}

TEST(FileLockTest, IsHeldByOneAtATime) {
  const TestDirectory directory;
  const auto take = [&] { FileLock(directory / "lock", "busy; wait for it"); };
  {
    const FileLock held(directory / "lock", "busy");
    EXPECT_EQ(error_of(take), directory.path().string() + ": busy; wait for it");
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
  fs::rename(directory / "lock", directory / "elsewhere");
  EXPECT_NO_THROW(FileLock(directory / "lock", "busy"));
  EXPECT_THROW(FileLock(directory / "elsewhere", "busy"), Error);
}

TEST(FileLockTest, UnwritableDirectoryIsNotReportedAsBusy) {
  const TestDirectory directory;
  EXPECT_THAT(error_of([&] { FileLock(directory / "missing/lock", "busy"); }),
              AllOf(HasSubstr("cannot write"), HasSubstr("missing"), Not(HasSubstr("busy"))));
  fs::create_directory(directory / "lock");
  EXPECT_THAT(error_of([&] { FileLock(directory / "lock", "busy"); }), HasSubstr("cannot write"));
}

}  // namespace
}  // namespace raywalk
