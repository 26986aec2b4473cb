#include "core/command_line/program_reference.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/command_line/config_option.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::Not;
using testing::UnorderedElementsAre;

// A program with every kind of option.
struct Sample {
  CLI::App app{"Works on rooms", "raywalk-test"};
  std::string room{}, lens{}, out{}, format{}, at{};
  std::vector<std::string> kinds{}, files{};
  int threads = 0;
  bool quiet = false;

  Sample() {
    app.set_version_flag("--version", std::string("raywalk-test 1.2.3"));
    app.require_subcommand(1);
    CLI::App* work = app.add_subcommand("work", "Do the work; it takes long");
    work->add_option("room", room, "Room directory")->required();
    work->add_option("-o,--out", out, "Where it's written: a \\file.\n'.hidden' too");
    work->add_option("--format", format, "Format of files")
        ->check(CLI::IsMember(std::vector<std::string>{"jpg", "png"}));
    work->add_option("--kinds", kinds, "Kinds")
        ->delimiter(',')
        ->check(CLI::IsMember(std::vector<std::string>{"one", "two"}));
    work->add_option("--threads", threads, "Threads to use")->check(CLI::Range(0, 64));
    work->add_option("--k", at, "Angle")->type_name("NUMBER|auto");
    work->add_option("--way", at, "Way")->type_name("sweep|flow");
    takes_config(work->add_option("--lens", lens, "Lens file"), ConfigKind::kLens);
    work->add_option("--secret", at, "Not for everyone")->group("");
    work->footer("Example:\n  raywalk-test work room.lf --out a\n.Text below.");
    app.add_subcommand("list", "List files")->add_option("files", files, "Files");
  }
};

const OptionReference& named(const std::vector<OptionReference>& options, const std::string& name) {
  for (const OptionReference& option : options) {
    if (option.flags.empty() ? option.value == name : option.flags.back() == name) return option;
  }
  throw Error("no option " + name);
}

TEST(ProgramReference, HasWhatTheCommandsTake) {
  const Sample sample;
  const ProgramReference program = reference_of(sample.app);
  EXPECT_EQ(program.version, "raywalk-test 1.2.3");
  ASSERT_EQ(program.commands.size(), 2U);
  const auto& options = program.commands.front().options;
  EXPECT_THAT(named(options, "--out").flags, ElementsAre("-o", "--out"));
  EXPECT_TRUE(named(options, "--out").takes_path);
  EXPECT_TRUE(named(options, "room").takes_path && named(options, "room").required);
  EXPECT_THAT(named(options, "--format").choices, ElementsAre("jpg", "png"));
  EXPECT_FALSE(named(options, "--format").takes_path);
  EXPECT_TRUE(named(options, "--kinds").is_list);
  EXPECT_EQ(named(options, "--threads").limits, "0 - 64");
  EXPECT_THAT(named(options, "--k").choices, ElementsAre("auto"));
  EXPECT_THAT(named(options, "--way").choices, ElementsAre("sweep", "flow"));
  EXPECT_THAT(named(options, "--lens").choices, Contains("theta-like"));
  EXPECT_EQ(named(options, "--help").value, "");
  EXPECT_THROW(named(options, "--secret"), Error);
  EXPECT_TRUE(named(program.commands.back().options, "files").repeats);
}

std::string output_of(const std::string& command) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string output;
  for (int c = std::fgetc(pipe.get()); c != EOF; c = std::fgetc(pipe.get())) {
    output += static_cast<char>(c);
  }
  return output;
}

// What bash completes behind `words`, the last of which is being typed, in a directory with a file
// "a b.png".
std::vector<std::string> completed(const std::vector<std::string>& words) {
  const Sample sample;
  const TestDirectory directory;
  write_file_atomically(directory / "completion", bash_completion(reference_of(sample.app)));
  write_file_atomically(directory / "a b.png", "");
  std::istringstream lines(output_of(fmt::format(
      "cd {} && bash -c \"set -u; . ./completion; COMP_WORDS=(raywalk-test '{}'); COMP_CWORD={}; "
      "_raywalk_test; printf '%s\\n' \\\"\\${{COMPREPLY[@]}}\\\"\" 2>&1",
      directory.path().string(), fmt::join(words, "' '"), words.size())));
  std::vector<std::string> found;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) found.push_back(line);
  }
  return found;
}

TEST(BashCompletion, CompletesCommandsFlagsWordsAndFiles) {
  EXPECT_THAT(completed({""}), UnorderedElementsAre("work", "list"));
  EXPECT_THAT(completed({"--v"}), ElementsAre("--version"));
  EXPECT_THAT(completed({"work", "--"}),
              AllOf(IsSupersetOf({"--out", "--format", "--help"}), Not(Contains("--secret"))));
  EXPECT_THAT(completed({"work", "--format", ""}), ElementsAre("jpg", "png"));
  EXPECT_THAT(completed({"work", "--format", "=", "p"}), ElementsAre("png"));
  EXPECT_THAT(completed({"work", "--format", "="}), ElementsAre("jpg", "png"));
  EXPECT_THAT(completed({"work", "--kinds", "one,t"}), ElementsAre("one,two"));
  EXPECT_THAT(completed({"work", "-o", "a"}), ElementsAre("a b.png"));
  EXPECT_THAT(completed({"work", "--threads", ""}), IsEmpty());
  EXPECT_THAT(completed({"work", "--threads", "2", "a"}), ElementsAre("a b.png"));
  EXPECT_THAT(completed({"work", "--lens", "theta"}), ElementsAre("theta-like"));
  EXPECT_THAT(completed({"list", ""}), UnorderedElementsAre("a b.png", "completion"));
}

TEST(ManPage, DescribesProgramAndCommands) {
  const Sample sample;
  const std::string page = man_page(reference_of(sample.app), "2026-11-25");
  EXPECT_THAT(page, HasSubstr(".TH RAYWALK\\-TEST 1 2026-11-25 \"Raywalk 1.2.3\""));
  EXPECT_THAT(page, HasSubstr(".SS raywalk\\-test work\nDo the work; it takes long.\n"));
  EXPECT_THAT(page, HasSubstr("\\fB\\-o\\fR, \\fB\\-\\-out\\fR \\fITEXT\\fR\n"
                              "Where it's written: a \\efile. '.hidden' too.\n"));
  EXPECT_THAT(page, HasSubstr("Format of files. Valid: jpg, png.\n"));
  EXPECT_THAT(page, HasSubstr("Range: 0 \\- 64."));
  EXPECT_THAT(page, HasSubstr(".nf\nraywalk\\-test work room.lf \\-\\-out a\n.fi\n"));
  EXPECT_THAT(page, HasSubstr("\n\\&.Text below.\n"));
  EXPECT_THAT(page, Not(HasSubstr("secret")));
}

}  // namespace
}  // namespace raywalk
