// Work on several threads and its interrupts, other programs, and the memory that the system
// grants.
#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/base/child_process.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/base/recently_made.h"
#include "core/base/usable_memory.h"
#include "core/files/test_support.h"

namespace raywalk {
namespace {

using ::testing::ElementsAre;
using ::testing::Pointee;
namespace fs = std::filesystem;

TEST(ParallelFor, VisitsEveryIndexOnceInChunksOfAtMostTheGrain) {
  for (const int grain : {-3, 0, 1, 7, 64, 5000}) {
    std::vector<std::atomic<int>> visits(1000);
    std::atomic<int> longest{0};
    parallel_for(10, 1000, grain, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) ++visits[static_cast<std::size_t>(i)];
      int seen = longest;
      while (seen < end - begin && !longest.compare_exchange_weak(seen, end - begin)) {
      }
    });
    for (int i = 0; i < 1000; ++i) {
      ASSERT_EQ(visits[static_cast<std::size_t>(i)], i < 10 ? 0 : 1) << i << " grain " << grain;
    }
    EXPECT_LE(longest, std::max(grain, 1));
  }
}

TEST(ParallelFor, EmptyRangeMakesNoCalls) {
  const auto fail = [](int, int) { FAIL() << "called"; };
  parallel_for(3, 3, 1, fail);
  parallel_for(3, -3, 1, fail);
}

TEST(ParallelFor, ExceptionOfTheBodyReachesTheCaller) {
  EXPECT_THROW(parallel_for(0, 100, 1,
                            [](int begin, int) {
                              if (begin == 57) throw Error("left_057.jpg: cut short");
                            }),
               Error);
}

// What the inner loop should have made would be used.
TEST(ParallelFor, AnInnerLoopWhoseOuterOneFailedDoesNotReturnAsIfDone) {
  if (thread_count() < 2) GTEST_SKIP() << "needs two threads";
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  const auto in_time = [&] { return std::chrono::steady_clock::now() < end; };
  std::atomic<bool> inside = false, left_out = false;
  const auto body = [&](int begin, int) {
    if (begin == 1) {
      while (!inside && in_time()) std::this_thread::yield();
      throw Error("left_057.jpg: cut short");
    }
    inside = true;
    while (!left_out && in_time()) {
      bool made = false;
      parallel_for(0, 1, 1, [&](int, int) { made = true; });
      left_out = !made;
    }
  };
  EXPECT_THROW(parallel_for(0, 2, 1, body), Error);
  EXPECT_FALSE(left_out);
}

// In a process of its own, as outside of WatchInterrupts a signal is remembered for good.
template <typename Condition>
void expect_in_own_process(const Condition& holds) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(std::exit(holds() ? 42 : 1), testing::ExitedWithCode(42), "");
}

// In a process of its own, that the signal is to end.
template <typename Action>
void expect_killed_by(int signal, const Action& action) {
  const auto end = [&] {
    action();
    std::raise(signal);
    std::exit(0);
  };
  EXPECT_EXIT(end(), testing::KilledBySignal(signal), "");
}

bool is_interrupted(const std::function<void()>& work) {
  try {
    work();
  } catch (const Interrupted&) {
    return true;
  }
  return false;
}

TEST(ParallelForDeathTest, CtrlCEndsTheLoop) {
  expect_in_own_process([] {
    install_interrupt_handlers();
    set_thread_count(1);
    int chunks = 0;
    const auto third_raises = [&](int, int) {
      if (++chunks == 3) std::raise(SIGINT);
    };
    return is_interrupted([&] { parallel_for(0, 100, 1, third_raises); }) && chunks == 3;
  });
}

TEST(ThreadCount, LimitsLoopsAndOpenCvAlikeAndIsNotNegative) {
  set_thread_count(1);
  EXPECT_EQ(thread_count(), 1);
  EXPECT_EQ(cv::getNumThreads(), 1);
  set_thread_count(0);
  EXPECT_GE(thread_count(), 1);
  EXPECT_EQ(cv::getNumThreads(), thread_count());
  EXPECT_THROW(set_thread_count(-1), UsageError);
}

TEST(CheckInParallel, TheFirstFailureIsReportedWhateverTheOrder) {
  for (int attempt = 0; attempt < 20; ++attempt) {
    std::atomic<int> checked = 0;
    const auto check = [&](int i) {
      ++checked;
      if (i == 417 || i == 3 || i > 900) throw Error(std::to_string(i));
    };
    EXPECT_EQ(error_of([&] { check_in_parallel(1000, check); }), "3");
    EXPECT_LE(checked, 1000);
  }
  std::atomic<int> sum = 0;
  check_in_parallel(100, [&](int i) { sum += i; });
  EXPECT_EQ(sum, 4950);
}

TEST(RecentlyMadeTest, KeepsTheValuesUsedLast) {
  std::vector<int> made;
  RecentlyMade<int, std::string> values(2, [&](int key) {
    made.push_back(key);
    return std::to_string(key);
  });
  for (const int key : {1, 2, 1, 3, 1, 2}) EXPECT_EQ(*values.get(key), std::to_string(key));
  EXPECT_THAT(made, ElementsAre(1, 2, 3, 2));
}

TEST(RecentlyMadeTest, GivesManyAtOnceInTheirOrderEvenMoreThanAreKept) {
  std::atomic<int> made = 0;
  RecentlyMade<int, int> values(2, [&](int key) {
    ++made;
    return 10 * key;
  });
  const auto held = values.get(4);
  const std::vector<int> keys{4, 0, 1, 2};
  EXPECT_THAT(values.get_all(keys), ElementsAre(held, Pointee(0), Pointee(10), Pointee(20)));
  EXPECT_EQ(made, 4);
  EXPECT_EQ(*held, 40);
  EXPECT_TRUE(values.get_all({}).empty());
}

TEST(RecentlyMadeTest, CanBeUsedBySeveralThreads) {
  RecentlyMade<int, int> values(2, [](int key) { return 10 * key; });
  parallel_for(0, 40, 1,
               [&](int begin, int) { EXPECT_EQ(*values.get(begin % 5), 10 * (begin % 5)); });
}

TEST(InterruptDeathTest, EverySignalToStopIsThrownAsInterrupted) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    expect_in_own_process([&] {
      install_interrupt_handlers();
      std::raise(signal);
      return is_interrupted(throw_if_interrupted) && interrupt_requested();
    });
  }
}

TEST(InterruptDeathTest, SighupIgnoredByNohupStaysIgnored) {
  expect_in_own_process([] {
    std::signal(SIGHUP, SIG_IGN);
    install_interrupt_handlers();
    std::raise(SIGHUP);
    {
      const DeferStopSignals protection;
      std::raise(SIGHUP);
    }
    std::raise(SIGHUP);
    return !interrupt_requested();
  });
}

TEST(InterruptDeathTest, SecondSigintEndsTheProcessAtOnce) {
  expect_killed_by(SIGINT, [] {
    install_interrupt_handlers();
    std::raise(SIGINT);
  });
}

TEST(InterruptDeathTest, DeferredSignalsDoNotEndTheProcessUntilHandlersAreRestored) {
  expect_in_own_process([] {
    install_interrupt_handlers();
    const DeferStopSignals protection;
    for (const int signal : {SIGINT, SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::raise(signal);
    return interrupt_requested();
  });
  expect_killed_by(SIGHUP, [] { const DeferStopSignals protection; });
}

// A host program's own handler.
volatile std::sig_atomic_t host_signals = 0;
void count_signal(int /*signal*/) { host_signals = host_signals + 1; }

TEST(InterruptDeathTest, WatchedSigintStopsWorkAndReachesTheHost) {
  expect_in_own_process([] {
    std::signal(SIGINT, count_signal);
    {
      const WatchInterrupts outer;
      {
        const WatchInterrupts inner;
        std::raise(SIGINT);
      }
      if (!interrupt_requested()) return false;
    }
    if (interrupt_requested()) return false;
    std::raise(SIGINT);  // of the host alone
    return !interrupt_requested() && host_signals == 2;
  });
}

TEST(InterruptDeathTest, WatchedSigintWithoutAHandlerEndsTheProcess) {
  EXPECT_EXIT(
      {
        const WatchInterrupts watch;
        std::raise(SIGINT);
        std::exit(0);
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST(InterruptDeathTest, WatchingWaitsForWorkThatWasInterrupted) {
  expect_in_own_process([] {
    std::signal(SIGINT, count_signal);
    auto interrupted = std::make_unique<WatchInterrupts>();
    std::raise(SIGINT);
    bool stops = true;
    std::thread later([&stops] {
      const WatchInterrupts watch;
      stops = interrupt_requested();
    });
    interrupted.reset();
    later.join();
    return !stops;
  });
}

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
