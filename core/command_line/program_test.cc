#include "core/command_line/program.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <iostream>
#include <new>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/command_line/command_options.h"
#include "core/command_line/wrong_usage.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;

struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string err;
};

int exit_code_of(CLI::App& app, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "raywalk-test");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  return run_program(app, static_cast<int>(arguments.size()), argv.data());
}

// Runs "raywalk-test <arguments>", whose subcommand `work` calls `work`.
Outcome run(
    std::vector<std::string> arguments, const std::function<void()>& work = [] {}) {
  CLI::App app("A program under test", "raywalk-test");
  app.set_version_flag("--version", "raywalk 0.1.0");
  app.require_subcommand(1);
  CLI::App* command = app.add_subcommand("work", "Does the work");
  double k_deg = 0.0;
  command->add_option("--k", k_deg);
  command->callback(work);

  Outcome outcome;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  outcome.exit_code = exit_code_of(app, std::move(arguments));
  outcome.err = testing::internal::GetCapturedStderr();
  outcome.out = testing::internal::GetCapturedStdout();
  return outcome;
}

TEST(RunProgram, HelpAndVersionGoToStdoutAndAreNoFailure) {
  for (const auto& [arguments, shown] :
       std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--help"}, "Does the work"}, {{"work", "--help"}, "--k"}, {{"--version"}, "0.1.0"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << shown;
    EXPECT_THAT(outcome.out, HasSubstr(shown));
    EXPECT_EQ(outcome.err, "");
  }
}

TEST(RunProgram, WrongCommandLinesAreOneLineAndExitCode2) {
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {}, {"wrok"}, {"work", "--l", "1"}, {"work", "--k", "many"}, {"work", "extra"}}) {
    const Outcome outcome = run(arguments, [] { FAIL() << "must not run"; });
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, testing::MatchesRegex("raywalk-test: error: [^\n]+; see raywalk-test( "
                                                   "work)? --help\n"));
    EXPECT_EQ(outcome.out, "");
  }
}

template <typename Exception>
void expect_failure(const Exception& exception, int exit_code, const std::string& line) {
  const Outcome failed = run({"work"}, [&] { throw Exception(exception); });
  EXPECT_EQ(failed.exit_code, exit_code) << failed.err;
  EXPECT_THAT(failed.err, HasSubstr(line));
  EXPECT_EQ(std::count(failed.err.begin(), failed.err.end(), '\n'), 1) << failed.err;
}

TEST(RunProgram, EveryKindOfFailureHasItsExitCodeAndLine) {
  const std::string error = "raywalk-test: error: ";
  expect_failure(Error("a.jpg: empty"), 1, error + "a.jpg: empty\n");
  expect_failure(UsageError("view.yaml:3: unknown key 'q'"), 2,
                 error + "view.yaml:3: unknown key 'q'\n");
  expect_failure(Paused("station x0_003: stalled; look"), 3,
                 error + "station x0_003: stalled; look\n");
  expect_failure(Interrupted("interrupted"), 130, error + "interrupted; no result was written\n");
  expect_failure(Interrupted("interrupted; look"), 130, error + "interrupted; look\n");
  expect_failure(std::logic_error("impossible"), 1, "(impossible)");
  expect_failure(std::logic_error("impossible"), 1, "please report");
  expect_failure(std::bad_alloc(), 1, "out of memory");
  expect_failure(cv::Exception(cv::Error::StsNoMem, "too large", "", "", 0), 1, "out of memory");
  expect_failure(cv::Exception(cv::Error::StsBadArg, "first\nsecond", "", "", 0), 1,
                 "first > second");
  expect_failure(7, 1, "");
}

TEST(RunProgram, FilesystemErrorsNameThePath) {
  const Outcome outcome =
      run({"work"}, [] { std::filesystem::create_directory("/proc/no/such/place"); });
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err, "raywalk-test: error: /proc/no/such/place: No such file or directory\n");
}

TEST(RunProgram, QuietPrintsOnlyWarningsAndErrors) {
  const auto work = [] {
    std::cout << "a line of results\n";
    Progress progress("working", 3, "steps");
    progress.advance(3);
    spdlog::info("a step is done");
    spdlog::warn("station 7 has no distances");
  };
  const Outcome loud = run({"work"}, work);
  EXPECT_EQ(loud.out, "a line of results\n");
  EXPECT_THAT(loud.err, HasSubstr("3 of 3 steps"));
  EXPECT_THAT(loud.err, HasSubstr("a step is done"));
  for (const char* flag : {"-q", "--quiet"}) {
    const Outcome quiet = run({"work", flag}, work);
    EXPECT_EQ(quiet.exit_code, 0);
    EXPECT_EQ(quiet.out, "");
    EXPECT_EQ(quiet.err, "raywalk-test: warning: station 7 has no distances\n");
  }
  EXPECT_EQ(run({"work", "-q"}, [] { throw Error("a.jpg: empty"); }).err,
            "raywalk-test: error: a.jpg: empty\n");
  EXPECT_EQ(run({"work"}, work).out, loud.out) << "one quiet run does not silence the next";
}

TEST(RunProgram, FileNamesAreEscapedInErrorsLogAndProgress) {
  const std::string name = "a\n\x1b[31m\xFF.jpg";
  const std::string shown = R"(a\n\u001b[31m\xff.jpg)";
  expect_failure(Error(name + ": empty"), 1, "raywalk-test: error: " + shown + ": empty\n");
  const Outcome logged = run({"work"}, [&] {
    spdlog::warn("{}: no distances", name);
    Progress(name, 1, "frames").advance();
  });
  EXPECT_THAT(logged.err, HasSubstr("raywalk-test: warning: " + shown + ": no distances\n"));
  EXPECT_THAT(logged.err, HasSubstr("\n" + shown + ": 1 of 1 frames"));
  EXPECT_THAT(run({"work", name}).err, HasSubstr(shown));
}

// Runs a program that prints a line while stdout is `descriptor`; returns its exit code.
int exit_code_with_stdout(int descriptor) {
  CLI::App app("", "raywalk-test");
  app.callback([] { std::cout << "a line of results\n"; });
  dup2(descriptor, STDOUT_FILENO);
  return exit_code_of(app, {});
}

// These break stdout, so each runs in its own process.
TEST(RunProgramDeathTest, ResultsThatCannotBeWrittenAreAFailure) {
  EXPECT_EXIT(std::_Exit(exit_code_with_stdout(open("/dev/full", O_WRONLY))),
              testing::ExitedWithCode(1), "raywalk-test: error: cannot write to standard output");
}

TEST(RunProgramDeathTest, ClosedPipeIsNoFailure) {
  EXPECT_EXIT(
      {
        int ends[2] = {};
        if (pipe(ends) != 0) std::_Exit(9);
        close(ends[0]);
        std::_Exit(exit_code_with_stdout(ends[1]));
      },
      testing::ExitedWithCode(0), "^$");
}

int exit_code_after_ctrl_c() {
  CLI::App app("", "raywalk-test");
  CLI::App* command = app.add_subcommand("work", "Does the work");
  add_resumption(command);
  command->callback([] {
    std::raise(SIGINT);
    throw_if_interrupted();
  });
  return exit_code_of(app, {"work"});
}

TEST(RunProgramDeathTest, CtrlCGives130AndSaysThatTheCommandResumes) {
  EXPECT_EXIT(std::_Exit(exit_code_after_ctrl_c()), testing::ExitedWithCode(130),
              "error: interrupted; what is finished is kept, the same command resumes");
}

TEST(ThreadsOptionTest, TakesANumberOfThreads) {
  int threads = -1;
  CLI::App app;
  add_threads_option(&app, &threads);
  app.parse("--threads 0");
  EXPECT_EQ(threads, 0);
  app.parse("--threads 7");
  EXPECT_EQ(threads, 7);
  EXPECT_THROW(app.parse("--threads -1"), CLI::ValidationError);
  EXPECT_THROW(app.parse("--threads many"), CLI::ParseError);
}

TEST(OneOfTest, AnotherWordIsRefusedWithTheNearest) {
  CLI::App app("", "raywalk-test");
  std::string method;
  app.add_option("--method", method)->check(one_of({"initial", "hlf-vd", "two-sided"}));
  app.parse("--method hlf-vd");
  EXPECT_EQ(method, "hlf-vd");
  EXPECT_THAT(app.help(), testing::HasSubstr("{initial,hlf-vd,two-sided}"));
  EXPECT_THAT([&] { app.parse("--method twosided"); },
              testing::ThrowsMessage<CLI::ParseError>(
                  "--method: 'twosided' is not a valid choice; did you mean 'two-sided'?"));
}

TEST(LineToleranceOptionsTest, GiveMetres) {
  GridTolerance tolerance;
  CLI::App app("", "raywalk-test");
  add_line_tolerance_options(&app, &tolerance);
  app.parse("");
  EXPECT_FALSE(tolerance.off_line_m);
  EXPECT_FALSE(tolerance.same_station_m);
  app.parse("--line-tolerance-mm 250 --same-station-mm 2.5");
  EXPECT_DOUBLE_EQ(*tolerance.off_line_m, 0.25);
  EXPECT_DOUBLE_EQ(*tolerance.same_station_m, 0.0025);
  for (const char* wrong : {"0", "-1", "nan", "inf", "2e6", "wide"}) {
    for (const char* option : {"--line-tolerance-mm ", "--same-station-mm "}) {
      EXPECT_THROW(app.parse(std::string(option) + wrong), CLI::ParseError) << option << wrong;
    }
  }
}

class WrongUsageTest : public testing::Test {
 protected:
  WrongUsageTest() {
    app_.require_subcommand(1);
    CLI::App* pack = app_.add_subcommand("pack");
    pack->add_option("--frames", text_)->required();
    pack->add_option("-o,--out", text_);
    pack->add_option("--line-tolerance-mm", number_);
    pack->add_flag("-f,--force", flag_);
    CLI::App* info = app_.add_subcommand("info");
    info->add_option("room", text_)->required();
  }

  // What is said of these words, split at spaces.
  std::string message(const std::string& line) {
    std::istringstream stream(line);
    std::vector<std::string> words(std::istream_iterator<std::string>(stream), {});
    try {
      require_double_dashes(app_, words);
      std::reverse(words.begin(), words.end());
      app_.parse(words);
    } catch (const UsageError& e) {
      return e.what();
    } catch (const CLI::ParseError& e) {
      return wrong_usage(app_, e);
    }
    return "no error";
  }

  CLI::App app_{"", "raywalk-test"};
  std::string text_;
  double number_ = 0.0;
  bool flag_ = false;
};

TEST_F(WrongUsageTest, UnknownFlagIsNamedWithTheNearestAndTheCommandsHelp) {
  for (const auto& [flag, nearest] : std::vector<std::pair<std::string, std::string>>{
           {"--frame", "--frames"},
           {"--line_tolerance_mm=3", "--line-tolerance-mm"},
           {"--line", "--line-tolerance-mm"},
           {"--output", "--out"},
           // Long flags behind a single dash are not read as short ones.
           {"-out", "--out"},
           {"-force", "--force"}}) {
    EXPECT_EQ(message("pack --frames a " + flag),
              "unknown flag '" + flag.substr(0, flag.find('=')) + "'; did you mean '" + nearest +
                  "'?; see raywalk-test pack --help");
  }
  EXPECT_EQ(message("pack --frames a --zzyzx"),
            "unknown flag '--zzyzx'; see raywalk-test pack --help");
  EXPECT_EQ(message("pack --frames a -z"), "unknown flag '-z'; see raywalk-test pack --help");
  EXPECT_EQ(message("pack --frames a -ob"), "no error") << "-o with its value";
}

TEST_F(WrongUsageTest, UnknownCommandIsNamedWithTheNearestAndTheProgramsHelp) {
  EXPECT_EQ(message("pakc --frames a"),
            "unknown command 'pakc'; did you mean 'pack'?; see raywalk-test --help");
  EXPECT_EQ(message("Info room.lf"),
            "unknown command 'Info'; did you mean 'info'?; see raywalk-test --help");
  EXPECT_EQ(message("render"),
            "unknown command 'render'; valid are pack, info; see raywalk-test --help");
}

TEST_F(WrongUsageTest, OtherMistakesLeadToTheCommandsHelp) {
  const std::string of_pack = "; see raywalk-test pack --help";
  EXPECT_EQ(message("--frames a pack"), "the flag '--frames' goes behind its command" + of_pack);
  EXPECT_EQ(message("--zzyzx info room.lf"),
            "unknown flag '--zzyzx'; see raywalk-test info --help");
  EXPECT_EQ(message("pack"), "--frames is required" + of_pack);
  EXPECT_EQ(message("pack --frames --out room.lf"),
            "--frames needs a value, but '--out' follows" + of_pack);
  EXPECT_THAT(message("pack --frames a --line-tolerance-mm many"),
              AllOf(HasSubstr("many"), EndsWith(of_pack)));
  EXPECT_THAT(message("info room.lf more"),
              AllOf(HasSubstr("more"), EndsWith("; see raywalk-test info --help")));
  EXPECT_THAT(message(""), EndsWith("; see raywalk-test --help"));
  EXPECT_THAT(message("info room.lf --a\x1b[31m"),
              testing::StartsWith("unknown flag '--a\\u001b[31m'"))
      << "no control characters";
}

}  // namespace
}  // namespace raywalk
