#include "core/command_line/program.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <filesystem>
#include <functional>
#include <iostream>
#include <new>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/command_line/command_options.h"

namespace raywalk {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string err;
};

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
  arguments.insert(arguments.begin(), "raywalk-test");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);

  Outcome outcome;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  outcome.exit_code = run_program(app, static_cast<int>(arguments.size()), argv.data());
  outcome.err = testing::internal::GetCapturedStderr();
  outcome.out = testing::internal::GetCapturedStdout();
  return outcome;
}

template <typename Exception>
Outcome run_throwing(Exception exception) {
  return run({"work"}, [&] { throw Exception(exception); });
}

TEST(RunProgram, DoneIsSilent) {
  const Outcome outcome = run({"work"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST(RunProgram, HelpAndVersionGoToStdoutAndAreNoFailure) {
  const Outcome help = run({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.out, HasSubstr("Does the work"));
  EXPECT_EQ(help.err, "");
  const Outcome command_help = run({"work", "--help"});
  EXPECT_EQ(command_help.exit_code, 0);
  EXPECT_THAT(command_help.out, HasSubstr("--k"));
  const Outcome version = run({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.out, "raywalk 0.1.0\n");
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

TEST(RunProgram, EveryKindOfFailureHasItsExitCodeAndLine) {
  const Outcome failed = run_throwing(Error("a.jpg: empty"));
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_EQ(failed.err, "raywalk-test: error: a.jpg: empty\n");
  const Outcome usage = run_throwing(UsageError("view.yaml:3: unknown key 'q'"));
  EXPECT_EQ(usage.exit_code, 2);
  EXPECT_EQ(usage.err, "raywalk-test: error: view.yaml:3: unknown key 'q'\n");
  const Outcome paused = run_throwing(Paused("station x0_003: stalled; look"));
  EXPECT_EQ(paused.exit_code, 3);
  EXPECT_EQ(paused.err, "raywalk-test: error: station x0_003: stalled; look\n");
  const Outcome interrupted = run_throwing(Interrupted("interrupted"));
  EXPECT_EQ(interrupted.exit_code, 130);
  EXPECT_EQ(interrupted.err, "raywalk-test: error: interrupted; no result was written\n");
  EXPECT_EQ(run_throwing(Interrupted("interrupted; look")).err,
            "raywalk-test: error: interrupted; look\n");
  const Outcome other = run_throwing(std::logic_error("impossible"));
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.err, AllOf(HasSubstr("please report"), HasSubstr("(impossible)")));
  const Outcome memory = run_throwing(std::bad_alloc());
  EXPECT_EQ(memory.exit_code, 1);
  EXPECT_THAT(memory.err, HasSubstr("out of memory"));
  const Outcome picture = run({"work"}, [] { CV_Error(cv::Error::StsNoMem, "too large"); });
  EXPECT_EQ(picture.exit_code, 1);
  EXPECT_THAT(picture.err, HasSubstr("out of memory"));
  EXPECT_EQ(run_throwing(7).exit_code, 1);
}

TEST(RunProgram, FilesystemErrorsNameThePath) {
  const Outcome outcome =
      run({"work"}, [] { std::filesystem::create_directory("/proc/no/such/place"); });
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err, "raywalk-test: error: /proc/no/such/place: No such file or directory\n");
}

TEST(RunProgram, MessagesOfSeveralLinesAreFolded) {
  const Outcome outcome = run({"work"}, [] { CV_Error(cv::Error::StsBadArg, "first\nsecond"); });
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("first > second"));
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
  const Outcome failed = run_throwing(Error(name + ": empty"));
  EXPECT_EQ(failed.err, "raywalk-test: error: " + shown + ": empty\n");
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
  std::string name = "raywalk-test";
  char* argv[] = {name.data(), nullptr};
  dup2(descriptor, STDOUT_FILENO);
  return run_program(app, 1, argv);
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
  std::string name = "raywalk-test", work = "work";
  std::vector<char*> argv = {name.data(), work.data(), nullptr};
  return run_program(app, 2, argv.data());
}

TEST(RunProgramDeathTest, CtrlCGives130AndSaysThatTheCommandResumes) {
  EXPECT_EXIT(std::_Exit(exit_code_after_ctrl_c()), testing::ExitedWithCode(130),
              "error: interrupted; what is finished is kept, the same command resumes");
}

}  // namespace
}  // namespace raywalk
