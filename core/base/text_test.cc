// What users read: text, numbers and progress; and the statistics behind them.
#include <gmock/gmock.h>
#include <poll.h>
#include <pty.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/median.h"
#include "core/base/number_text.h"
#include "core/base/pick_evenly.h"
#include "core/base/progress.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TEST(OneLine, FoldsLineBreaksTrimsAndKeepsNoControlCharacterForTheTerminal) {
  EXPECT_EQ(one_line("  OpenCV(4.6.0)\r\n\terror: (-215)  in 'f'\n"),
            "OpenCV(4.6.0) error: (-215) in 'f'");
  EXPECT_EQ(one_line("a\x1b[31mred\x7f"), R"(a\u001b[31mred\u007f)");
}

TEST(Excerpt, ShowsTheTextAndIsCutBetweenCharacters) {
  EXPECT_EQ(excerpt("a  b\n"), R"('a  b\n')");
  EXPECT_EQ(excerpt(std::string(1000, 'x')), fmt::format("'{}...'", std::string(60, 'x')));
  // 1 byte and 2-byte characters: 59 is the longest whole number of them below 60.
  const std::string umlauts = "xöööööööööööööööööööööööööööööööööööööööö";
  EXPECT_EQ(excerpt(umlauts), fmt::format("'{}...'", umlauts.substr(0, 59)));
}

TEST(Escaped, KeepsTextOfAllScripts) {
  const std::string text = "Größe 90°, 部屋 \xF0\x9F\x93\xB7 'a' \\ \"b\"";
  EXPECT_EQ(escaped(text), text);
  EXPECT_EQ(escaped(""), "");
}

TEST(ShellWord, IsTakenByAShellAsTheName) {
  EXPECT_EQ(shell_word("hall/poses-2.csv"), "hall/poses-2.csv");
  EXPECT_EQ(shell_word("my hall"), "'my hall'");
  EXPECT_EQ(shell_word("a'b$c"), R"('a'\''b$c')");
  EXPECT_EQ(shell_word("Größe"), "'Größe'");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(Escaped, ShowsControlCharactersLineBreaksTurnedTextAndBytesThatAreNotUtf8) {
  EXPECT_EQ(escaped("a\nb\tc\r"), R"(a\nb\tc\r)");
  EXPECT_EQ(escaped("\x1b[31mred\x7f"), R"(\u001b[31mred\u007f)");
  EXPECT_EQ(escaped(std::string_view("a\0b", 3)), R"(a\u0000b)");
  EXPECT_EQ(escaped("\xC2\x9B[2J"), R"(\u009b[2J)");  // U+009B, as ESC [
  EXPECT_EQ(escaped("a\u2028b"), R"(a\u2028b)");
  EXPECT_EQ(escaped("a\u202Egpj.exe"), R"(a\u202egpj.exe)");
  EXPECT_EQ(escaped("a\xFFz"), R"(a\xffz)");
  EXPECT_EQ(escaped("a\xC3"), R"(a\xc3)");                        // cut short
  EXPECT_EQ(escaped("\xC3("), R"(\xc3()");                        // bad continuation
  EXPECT_EQ(escaped("\xC0\xBC"), R"(\xc0\xbc)");                  // overlong '<'
  EXPECT_EQ(escaped("\xE0\x80\xBC"), R"(\xe0\x80\xbc)");          // overlong '<'
  EXPECT_EQ(escaped("\xED\xA0\x80"), R"(\xed\xa0\x80)");          // surrogate
  EXPECT_EQ(escaped("\xF4\x90\x80\x80"), R"(\xf4\x90\x80\x80)");  // over U+10FFFF
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(FixedNumber, HasAllItsDecimalsOrADashForWhatIsNotFinite) {
  EXPECT_EQ(fixed_number(2.0, 2), "2.00");
  EXPECT_EQ(fixed_number(-3.14159, 1), "-3.1");
  EXPECT_EQ(fixed_number(100.0, 0), "100");
  EXPECT_EQ(fixed_number(-0.0004, 3), "0.000");
  EXPECT_EQ(number_or_dash(2.0, 2), "2.00");
  EXPECT_EQ(number_or_dash(std::nan(""), 2), "–");
  EXPECT_EQ(number_or_dash(-kInfinity, 2), "–");
}

TEST(PlainNumber, HasNoTrailingZerosAndPrintsAnyValue) {
  EXPECT_EQ(plain_number(2.0, 3), "2");
  EXPECT_EQ(plain_number(0.25, 3), "0.25");
  EXPECT_EQ(plain_number(-3.14159, 1), "-3.1");
  EXPECT_EQ(plain_number(100.0, 0), "100");
  EXPECT_EQ(plain_number(-0.0004, 3), "0");
  EXPECT_EQ(plain_number(std::nan(""), 2), "nan");
  EXPECT_EQ(plain_number(-kInfinity, 2), "-inf");
  EXPECT_EQ(plain_number(std::numeric_limits<double>::max(), 2).size(), 309U);
}

// What is logged while `work` runs.
template <typename Work>
std::string logged(const Work& work) {
  testing::internal::CaptureStderr();
  work();
  return testing::internal::GetCapturedStderr();
}

// Of 60 frames, of which so many are done.
std::string progress_of(int done, Progress::Shown shown = Progress::Shown::kAlways) {
  return logged([&] {
    Progress progress("packing", 60, "frames", shown);
    for (int i = 0; i < done; ++i) progress.advance();
  });
}

TEST(Progress, QuickWorkInALogIsOneLineWithWhatIsDone) {
  const std::string log = progress_of(60);
  EXPECT_THAT(log, StartsWith("packing: 60 of 60 frames (100 %)"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
  EXPECT_THAT(progress_of(59), Not(HasSubstr("100 %")));
  EXPECT_EQ(progress_of(60, Progress::Shown::kIfLong), "") << "not worth a line";
}

// From a second on there is a line, however small the share that is done.
TEST(Progress, LongWorkInALogIsShownFromASecondOn) {
  const std::string log = logged([] {
    Progress progress("looking for", 1000000, "frames", Progress::Shown::kIfLong);
    progress.advance();
    std::this_thread::sleep_for(std::chrono::milliseconds(1050));
    progress.advance();
  });
  EXPECT_THAT(log, StartsWith("looking for: 2 of 1000000 frames (0 %)"));
}

// What the first unit took says little: it also started the work.
TEST(Progress, WhatIsLeftIsNotEstimatedFromTheFirstSeconds) {
  const std::string log = logged([] {
    Progress progress("packing", 60, "frames");
    std::this_thread::sleep_for(std::chrono::milliseconds(1050));
    progress.advance(30);
  });
  EXPECT_THAT(log, AllOf(StartsWith("packing: 30 of 60 frames (50 %)"), Not(HasSubstr("left"))));
}

TEST(Progress, CountsFromAllThreadsAndWithoutATotal) {
  const std::string columns = logged([] {
    Progress progress("rendering", 4000, "columns");
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&progress] {
        for (int i = 0; i < 1000; ++i) progress.advance();
      });
    }
  });
  EXPECT_THAT(columns, HasSubstr("4000 of 4000 columns (100 %)"));
  const std::string without_total = logged([] {
    Progress("packing", 0, "frames").advance(0);
    Progress("reading", 0, "rows").advance(5);
  });
  EXPECT_THAT(without_total, Not(ContainsRegex("nan|inf|%")));
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
  EXPECT_THAT(shown, AllOf(StartsWith("\rpacking: 1 of 2 frames (50 %)"),
                           HasSubstr("\rpacking: 2 of 2 frames (100 %)"), EndsWith("\n")));
  EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 1);
}

TEST(Median, IsTheMiddleOrTheUpperOfTwo) {
  EXPECT_EQ(median({5.0, -1.0, 3.0}), 3.0);
  EXPECT_EQ(median({4.0, 1.0, 2.0, 3.0}), 3.0);
  EXPECT_EQ(median({7.5}), 7.5);
}

std::vector<double> absolute_normal(double sigma, int count) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.0, sigma);
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(std::fabs(normal(random)));
  return values;
}

TEST(RobustSigma, IsTheStandardDeviationHardlyMovedByOutliers) {
  std::vector<double> values = absolute_normal(0.5, 100000);
  EXPECT_NEAR(robust_sigma(values), 0.5, 0.005);
  values.insert(values.end(), 5000, 1e9);
  EXPECT_NEAR(robust_sigma(values), 0.5, 0.05);
  EXPECT_EQ(robust_sigma({0, 0, 0, 7, 9}), 0.0);
}

TEST(PickEvenly, TakesAllIfFewOtherwiseEvenly) {
  // The middles of equal parts.
  EXPECT_THAT(pick_evenly(100, 4), ::testing::ElementsAre(12, 37, 62, 87));
  EXPECT_THAT(pick_evenly(100, 1), ::testing::ElementsAre(50));
  EXPECT_THAT(pick_evenly(3, 3), ::testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(pick_evenly(3, 12), ::testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(pick_evenly(0, 12), ::testing::IsEmpty());
}

}  // namespace
}  // namespace raywalk
