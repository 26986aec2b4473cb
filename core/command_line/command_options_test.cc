#include "core/command_line/command_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/command_line/wrong_usage.h"

namespace raywalk {
namespace {

using Words = std::vector<std::string>;

TEST(ThreadsOptionTest, TakesANumberOfThreads) {
  int threads = -1;
  CLI::App app("", "raywalk-test");
  add_threads_option(&app, &threads);
  app.parse("--threads 0");
  EXPECT_EQ(threads, 0);
  app.parse("--threads 7");
  EXPECT_EQ(threads, 7);
  EXPECT_THROW(app.parse("--threads -1"), CLI::ValidationError);
  EXPECT_THROW(app.parse("--threads many"), CLI::ParseError);
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

TEST(OneOfTest, AnotherWordIsRefusedWithTheNearest) {
  CLI::App app("", "raywalk-test");
  std::string method;
  app.add_option("--method", method)->check(one_of({"initial", "hlf-vd", "two-sided"}));
  app.parse("--method hlf-vd");
  EXPECT_EQ(method, "hlf-vd");
  EXPECT_THAT(app.help(), testing::HasSubstr("{initial,hlf-vd,two-sided}"));
  try {
    app.parse("--method twosided");
    FAIL();
  } catch (const CLI::ParseError& e) {
    EXPECT_STREQ(e.what(), "--method: 'twosided' is not a valid choice; did you mean 'two-sided'?");
  }
}

TEST(QuietFlagTest, EveryCommandHasItAndJsonIsStillPrinted) {
  CLI::App app("", "raywalk-test");
  bool json = false;
  app.add_subcommand("info")->add_flag("--json", json);
  app.add_subcommand("work");
  std::vector<bool> results_silenced;
  add_quiet_flag(&app, [&](bool results) { results_silenced.push_back(results); });
  app.parse("work -q");
  app.parse("--quiet work");
  app.parse("info -q");
  app.parse("info -q --json");
  app.parse("info --json");
  EXPECT_THAT(results_silenced, testing::ElementsAre(true, true, true, false));
}

TEST(CommonOptionsTest, StayTogetherBehindGroupsOfOtherOptions) {
  CLI::App app("", "raywalk-test");
  int threads = 0;
  bool force = false;
  double blend_deg = 0.0;
  CLI::App* command = app.add_subcommand("work");
  command->option_defaults()->group("Panoramas");
  command->add_option("--blend-deg", blend_deg);
  add_threads_option(command, &threads);
  add_force_flag(command, &force, "Replace");
  add_quiet_flag(&app, [](bool) {});
  const std::string help = command->help();
  EXPECT_LT(help.find("--threads"), help.find("Panoramas"));
  EXPECT_LT(help.find("-f,--force"), help.find("Panoramas"));
  EXPECT_LT(help.find("-q,--quiet"), help.find("Panoramas"));
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

  std::string message(Words words) {
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
  const std::string hint = "; see raywalk-test pack --help";
  EXPECT_EQ(message({"pack", "--frame", "poses.csv"}),
            "unknown flag '--frame'; did you mean '--frames'?" + hint);
  EXPECT_EQ(message({"pack", "--frames", "a", "--line_tolerance_mm=3"}),
            "unknown flag '--line_tolerance_mm'; did you mean '--line-tolerance-mm'?" + hint);
  EXPECT_EQ(message({"pack", "--frames", "a", "--line", "3"}),
            "unknown flag '--line'; did you mean '--line-tolerance-mm'?" + hint);
  EXPECT_EQ(message({"pack", "--frames", "a", "--output", "b"}),
            "unknown flag '--output'; did you mean '--out'?" + hint);
  EXPECT_EQ(message({"pack", "--frames", "a", "--zzyzx"}), "unknown flag '--zzyzx'" + hint);
  EXPECT_EQ(message({"pack", "--frames", "a", "-z"}), "unknown flag '-z'" + hint);
}

TEST_F(WrongUsageTest, LongFlagBehindASingleDashIsNotReadAsShortOnes) {
  const std::string hint = "; see raywalk-test pack --help";
  EXPECT_EQ(message({"pack", "--frames", "a", "-out", "b"}),
            "unknown flag '-out'; did you mean '--out'?" + hint);
  EXPECT_EQ(message({"pack", "--frames", "a", "-force"}),
            "unknown flag '-force'; did you mean '--force'?" + hint);
  EXPECT_EQ(message({"pack", "--frames", "a", "-ob"}), "no error") << "-o with its value";
}

TEST_F(WrongUsageTest, UnknownCommandIsNamedWithTheNearestAndTheProgramsHelp) {
  EXPECT_EQ(message({"pakc", "--frames", "a"}),
            "unknown command 'pakc'; did you mean 'pack'?; see raywalk-test --help");
  EXPECT_EQ(message({"Info", "room.lf"}),
            "unknown command 'Info'; did you mean 'info'?; see raywalk-test --help");
  EXPECT_EQ(message({"render"}),
            "unknown command 'render'; valid are pack, info; see raywalk-test --help");
}

TEST_F(WrongUsageTest, FlagBeforeItsCommandGoesBehindIt) {
  EXPECT_EQ(message({"--frames", "a", "pack"}),
            "the flag '--frames' goes behind its command; see raywalk-test pack --help");
  EXPECT_EQ(message({"--zzyzx", "info", "room.lf"}),
            "unknown flag '--zzyzx'; see raywalk-test info --help");
}

TEST_F(WrongUsageTest, OtherMistakesLeadToTheCommandsHelp) {
  EXPECT_EQ(message({"pack"}), "--frames is required; see raywalk-test pack --help");
  EXPECT_THAT(message({"info", "room.lf", "more"}),
              testing::AllOf(testing::HasSubstr("more"),
                             testing::EndsWith("; see raywalk-test info --help")));
  EXPECT_EQ(message({"pack", "--frames", "--out", "room.lf"}),
            "--frames needs a value, but '--out' follows; see raywalk-test pack --help");
  EXPECT_THAT(message({"pack", "--frames", "a", "--line-tolerance-mm", "many"}),
              testing::AllOf(testing::HasSubstr("many"),
                             testing::EndsWith("; see raywalk-test pack --help")));
  EXPECT_THAT(message({}), testing::EndsWith("; see raywalk-test --help"));
}

TEST_F(WrongUsageTest, ControlCharactersAreNotPrinted) {
  EXPECT_THAT(message({"info", "room.lf", "--a\x1b[31m"}),
              testing::StartsWith("unknown flag '--a\\u001b[31m'"));
}

}  // namespace
}  // namespace raywalk
