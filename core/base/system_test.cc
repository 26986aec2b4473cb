// Other programs, and the memory that the system grants.
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>
#include <string>

#include "core/base/child_process.h"
#include "core/base/error.h"
#include "core/base/usable_memory.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class ChildProcessTest : public ::testing::Test {
 protected:
  int run_shell(const std::string& script) const {
    ChildProcess child("/bin/sh", {"-c", script}, log_);
    return child.wait();
  }

  TestDirectory directory_;
  std::filesystem::path log_ = directory_ / "log";
};

TEST_F(ChildProcessTest, OutputIsAppended) {
  EXPECT_TRUE(succeeded(run_shell("echo one; echo two >&2")));
  EXPECT_TRUE(succeeded(run_shell("cat; echo three")));  // stdin is empty
  EXPECT_EQ(text_of(log_), "one\ntwo\nthree\n");
}

TEST_F(ChildProcessTest, ArgumentsAreNotInterpretedByAShell) {
  ChildProcess child("/bin/echo", {"a b", "$HOME", "*", "'"}, log_);
  EXPECT_TRUE(succeeded(child.wait()));
  EXPECT_EQ(text_of(log_), "a b $HOME * '\n");
}

TEST_F(ChildProcessTest, InputIsWrittenUntilTheProgramEnds) {
  const std::string text(std::size_t{1} << 20, 'x');  // more than a pipe holds
  ChildProcess counts("/bin/sh", {"-c", "wc -c"}, log_, ChildInput::kWritten);
  EXPECT_TRUE(counts.write_input(std::as_bytes(std::span(text))));
  EXPECT_TRUE(counts.write_input(std::as_bytes(std::span(text))));
  counts.end_input();
  EXPECT_TRUE(succeeded(counts.wait()));
  EXPECT_EQ(text_of(log_), "2097152\n");

  // This program does not end by SIGPIPE with it.
  ChildProcess ends("/bin/sh", {"-c", "head -c 5 >/dev/null; exit 4"}, log_, ChildInput::kWritten);
  while (ends.write_input(std::as_bytes(std::span(text)))) continue;
  EXPECT_EQ(describe_failure(ends.wait()), "failed with exit code 4");
}

TEST_F(ChildProcessTest, FailuresAreDescribed) {
  EXPECT_EQ(describe_failure(run_shell("exit 3")), "failed with exit code 3");
  EXPECT_EQ(describe_failure(run_shell("kill -9 $$")), "was killed by signal 9");
  ChildProcess missing(directory_ / "nothing", {}, log_);
  EXPECT_EQ(describe_failure(missing.wait()), "failed with exit code 127");
  EXPECT_THROW(ChildProcess("/bin/true", {}, directory_ / "none/log"), Error);
}

TEST_F(ChildProcessTest, StoppingEndsDescendants) {
  ChildProcess child("/bin/sh", {"-c", "sleep 100 & echo $!; wait"}, log_);
  while (text_of(log_).find('\n') == std::string::npos) usleep(1000);
  const pid_t grandchild = std::stoi(text_of(log_));
  EXPECT_FALSE(child.try_wait());
  child.stop();
  EXPECT_TRUE(child.try_wait());
  // Ended; it may remain a zombie until init reaps it.
  const auto is_gone = [grandchild] {
    const std::string stat = text_of("/proc/" + std::to_string(grandchild) + "/stat");
    return stat.empty() || stat.find(") Z ") != std::string::npos;
  };
  for (int i = 0; i < 2000 && !is_gone(); ++i) usleep(1000);
  EXPECT_TRUE(is_gone());
}

TEST_F(ChildProcessTest, ProgramThatIgnoresSigtermIsKilled) {
  ChildProcess child("/bin/sh", {"-c", "trap '' TERM; echo on; while :; do sleep 1; done"}, log_);
  while (text_of(log_).empty()) usleep(1000);
  child.stop();
  ASSERT_TRUE(child.try_wait());
  EXPECT_EQ(describe_failure(*child.try_wait()), "was killed by signal 9");
}

TEST(FindProgram, LooksForFilesThatCanBeRunInPath) {
  const TestDirectory first, second;
  const std::string before = std::getenv("PATH");
  setenv("PATH", (first.path().string() + ":" + second.path().string()).c_str(), 1);
  std::ofstream(first / "tool") << "not executable";
  EXPECT_FALSE(find_program("tool"));
  std::filesystem::create_symlink("/bin/sh", second / "tool");
  EXPECT_EQ(find_program("tool"), second / "tool");
  setenv("PATH", before.c_str(), 1);
}

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

class ControlGroupTest : public testing::Test {
 protected:
  void write(const fs::path& file, const std::string& text) const {
    fs::create_directories((directory_ / file.string()).parent_path());
    std::ofstream(directory_ / file.string()) << text;
  }
  std::uint64_t limit(const std::string& membership) const {
    write("membership", membership);
    return control_group_limit_bytes(directory_.path() / "membership",
                                     directory_.path() / "groups");
  }

  TestDirectory directory_;
};

TEST_F(ControlGroupTest, TakesTheSmallestLimitAroundAGroupOfVersion2) {
  write("groups/a/b/memory.max", "4000\n");
  write("groups/a/memory.max", "3000\n");
  write("groups/other/memory.max", "10\n");
  EXPECT_EQ(limit("0::/a/b\n"), 3000U);
  write("groups/a/memory.max", "max\n");
  EXPECT_EQ(limit("0::/a/b\n"), 4000U);
  write("groups/a/b/memory.max", "max\n");
  EXPECT_EQ(limit("0::/a/b\n"), kUnlimited);
}

TEST_F(ControlGroupTest, ReadsTheMemoryControllerOfVersion1) {
  write("groups/memory/job/memory.limit_in_bytes", "536870912\n");
  write("groups/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(limit("5:cpu,cpuacct:/x\n4:memory:/job\n0::/\n"), 536870912U);
  EXPECT_EQ(limit("5:memory_of_others:/job\n"), kUnlimited);
}

TEST_F(ControlGroupTest, FindsTheGroupOfAContainerAtTheMount) {
  write("groups/memory.max", "2000\n");
  EXPECT_EQ(limit("0::/unseen/outside\n"), 2000U);
}

TEST_F(ControlGroupTest, NothingReadableSetsNoLimit) {
  EXPECT_EQ(limit(""), kUnlimited);
  EXPECT_EQ(limit("nonsense\n0::\n::\n"), kUnlimited);
  EXPECT_EQ(control_group_limit_bytes(directory_.path() / "missing", "/missing"), kUnlimited);
}

TEST(UsableMemoryTest, IsNotMoreThanTheMachineHas) {
  std::ifstream info("/proc/meminfo");
  std::string label;
  std::uint64_t kilobytes = 0;
  ASSERT_TRUE(info >> label >> kilobytes);
  EXPECT_GT(usable_memory_bytes(), 0U);
  EXPECT_LE(usable_memory_bytes(), 1024 * kilobytes);
}

}  // namespace
}  // namespace raywalk
