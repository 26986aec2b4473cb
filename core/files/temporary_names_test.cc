#include "core/files/temporary_names.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// What a process leaves that writes to `target` and is killed.
template <typename Write>
void die_while_writing(const fs::path& target, const Write& write) {
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

TEST(TemporaryNames, LieHiddenBesideTheTargetWithItsExtension) {
  const TestDirectory directory;
  const fs::path first = temporary_beside(directory / "view.png");
  EXPECT_EQ(first.parent_path(), directory.path());
  EXPECT_EQ(first.extension(), ".png");
  EXPECT_TRUE(first.filename().string().starts_with(".view."));
  EXPECT_NE(temporary_beside(directory / "view.png"), first);
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
  const pid_t child = fork();
  if (child == 0) {
    write_file_atomically(directory / "other.txt", "text");
    std::_Exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(fs::exists(ours));
  write_file_atomically(directory / "third.txt", "text");
  EXPECT_TRUE(fs::exists(ours));
}

TEST(TemporaryNames, ThoseOfAnotherSystemStayForADay) {
  const TestDirectory directory;
  const fs::path file = directory / ".view.00000000-1.0.partial.png";
  write_text(file);
  remove_abandoned_temporaries(directory.path());
  EXPECT_TRUE(fs::exists(file));
  fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(25));
  remove_abandoned_temporaries(directory.path());
  EXPECT_FALSE(fs::exists(file));
}

TEST(TemporaryNames, OtherFilesStay) {
  const TestDirectory directory;
  for (const char* name : {"room.lf.partial", ".hidden", ".a.partial", "a.12345678-1.0.partial.png",
                           ".x0_007.jpg.partial", "trade.partial.json"}) {
    write_text(directory / name);
    fs::last_write_time(directory / name,
                        fs::file_time_type::clock::now() - std::chrono::hours(2500));
  }
  remove_abandoned_temporaries(directory.path());
  EXPECT_EQ(directory.entries(), 6U);
  EXPECT_NO_THROW(remove_abandoned_temporaries(directory / "missing"));
}

}  // namespace
}  // namespace raywalk
