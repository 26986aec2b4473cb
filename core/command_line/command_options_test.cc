#include "core/command_line/command_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace raywalk {
namespace {

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
  LineToleranceArguments arguments;
  CLI::App app("", "raywalk-test");
  add_line_tolerance_options(&app, &arguments);
  app.parse("");
  EXPECT_FALSE(tolerance_of(arguments).off_line_m);
  EXPECT_FALSE(tolerance_of(arguments).same_station_m);
  app.parse("--line-tolerance-mm 250 --same-station-mm 2.5");
  EXPECT_DOUBLE_EQ(*tolerance_of(arguments).off_line_m, 0.25);
  EXPECT_DOUBLE_EQ(*tolerance_of(arguments).same_station_m, 0.0025);
  for (const char* wrong : {"0", "-1", "nan", "inf", "2e6", "wide"}) {
    for (const char* option : {"--line-tolerance-mm ", "--same-station-mm "}) {
      EXPECT_THROW(app.parse(std::string(option) + wrong), CLI::ParseError) << option << wrong;
    }
  }
}

TEST(LineToleranceOptionsTest, StationsCannotCountAsOneBeyondTheLineTolerance) {
  EXPECT_THROW(tolerance_of({.line_tolerance_mm = 5.0, .same_station_mm = 5.1}), UsageError);
  EXPECT_NO_THROW(tolerance_of({.line_tolerance_mm = 5.0, .same_station_mm = 5.0}));
  EXPECT_NO_THROW(tolerance_of({.same_station_mm = 5.0}));
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

}  // namespace
}  // namespace raywalk
