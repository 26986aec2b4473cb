#include "core/base/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <array>
#include <string>
#include <thread>
#include <vector>

namespace raywalk {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

TEST(Progress, QuickWorkInALogIsOneLineWithTheTotal) {
  testing::internal::CaptureStderr();
  {
    Progress progress("packing", 60, "frames");
    for (int i = 0; i < 60; ++i) progress.advance();
  }
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, StartsWith("packing: 60 of 60 frames (100 %)"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
}

TEST(Progress, ShortWorkIsNotWorthALineWhereOnlyLongWorkIs) {
  testing::internal::CaptureStderr();
  {
    Progress progress("looking for", 60, "frames", Progress::Shown::kIfLong);
    progress.advance(60);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// From a second on there is a line, however small the share that is done.
TEST(Progress, LongWorkInALogIsShownFromASecondOn) {
  testing::internal::CaptureStderr();
  {
    Progress progress("looking for", 1000000, "frames", Progress::Shown::kIfLong);
    progress.advance();
    std::this_thread::sleep_for(std::chrono::milliseconds(1050));
    progress.advance();
  }
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              StartsWith("looking for: 2 of 1000000 frames (0 %)"));
}

// What the first unit took says little: it also started the work.
TEST(Progress, WhatIsLeftIsNotEstimatedFromTheFirstSeconds) {
  testing::internal::CaptureStderr();
  {
    Progress progress("packing", 60, "frames");
    std::this_thread::sleep_for(std::chrono::milliseconds(1050));
    progress.advance(30);
  }
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(StartsWith("packing: 30 of 60 frames (50 %)"), Not(HasSubstr("left"))));
}

TEST(Progress, UnfinishedWorkDoesNotClaimToBeDone) {
  testing::internal::CaptureStderr();
  {
    Progress progress("packing", 60, "frames");
    progress.advance(59);
  }
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::Not(HasSubstr("100 %")));
}

TEST(Progress, CountsFromAllThreads) {
  testing::internal::CaptureStderr();
  {
    Progress progress("rendering", 4000, "columns");
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&progress] {
        for (int i = 0; i < 1000; ++i) progress.advance();
      });
    }
    for (std::thread& thread : threads) thread.join();
  }
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("4000 of 4000 columns (100 %)"));
}

TEST(Progress, UnknownOrZeroTotalIsSupported) {
  testing::internal::CaptureStderr();
  {
    Progress nothing("packing", 0, "frames");
    nothing.advance(0);
    Progress unknown("reading", 0, "rows");
    unknown.advance(5);
  }
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, testing::Not(ContainsRegex("nan|inf|%")));
}

// Runs `work` with stderr on a pseudo-terminal and returns the terminal output.
template <typename Work>
std::string terminal_output_of(Work work) {
  int controller = -1;
  int terminal = -1;
  if (openpty(&controller, &terminal, nullptr, nullptr, nullptr) != 0) return "no pseudo-terminal";
  const int saved = dup(STDERR_FILENO);
  dup2(terminal, STDERR_FILENO);
  work();
  dup2(saved, STDERR_FILENO);
  close(saved);
  // The kernel delivers the output in pieces; the last one ends with a newline.
  constexpr int kPatienceMs = 5000;
  std::string shown;
  std::array<char, 4096> buffer = {};
  pollfd readable = {controller, POLLIN, 0};
  while (!shown.ends_with('\n') && poll(&readable, 1, kPatienceMs) > 0) {
    const ssize_t count = read(controller, buffer.data(), buffer.size());
    if (count <= 0) break;
    shown.append(buffer.data(), static_cast<std::size_t>(count));
  }
  close(terminal);
  close(controller);
  return shown;
}

TEST(Progress, OnATerminalOneLineIsRewrittenAndThenEnded) {
  const std::string shown = terminal_output_of([] {
    Progress progress("packing", 2, "frames");
    progress.advance();
    progress.advance();
  });
  EXPECT_THAT(shown, StartsWith("\rpacking: 1 of 2 frames (50 %)"));
  EXPECT_THAT(shown, HasSubstr("\rpacking: 2 of 2 frames (100 %)"));
  EXPECT_THAT(shown, EndsWith("\n"));
  EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 1);
}

}  // namespace
}  // namespace raywalk
