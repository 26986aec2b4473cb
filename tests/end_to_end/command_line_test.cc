// What holds for the command line of every command of every program.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/files/test_support.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::EndsWith;
using testing::HasSubstr;
namespace fs = std::filesystem;

struct Command {
  std::string program;  // its path
  std::string name;
  std::string help;

  std::string shown() const { return fs::path(program).filename().string() + " " + name; }
  CommandResult run(const std::string& arguments) const {
    return run_command(program + " " + name + " " + arguments);
  }
};

// "  pack      Pack captured panoramas into a room" below "Subcommands:".
std::vector<std::string> commands_in(const std::string& help) {
  std::vector<std::string> names;
  std::istringstream lines(help.substr(help.find("Subcommands:")));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line) && line.rfind("  ", 0) == 0) {
    std::string name;
    std::istringstream(line) >> name;
    if (line[2] != ' ') names.push_back(name);
  }
  return names;
}

const std::vector<Command>& all_commands() {
  static const std::vector<Command> commands = [] {
    std::vector<Command> found;
    for (const char* program :
         {RAYWALK_CAPTURE, RAYWALK_CALIBRATE, RAYWALK_BUILD_LF, RAYWALK_RENDER, RAYWALK_SIMULATE}) {
      for (const std::string& name :
           commands_in(run_command(std::string(program) + " --help").output)) {
        Command command{program, name, ""};
        command.help = command.run("--help").output;
        found.push_back(command);
      }
    }
    return found;
  }();
  return commands;
}

// Long flags of a help text, without dashes: those in front of a description.
std::set<std::string> flags_in(const std::string& help) {
  std::set<std::string> flags;
  std::istringstream lines(help);
  const std::regex flag("--([a-z][a-z-]*)");
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("  -", 0) != 0) continue;
    const std::string names = line.substr(0, line.find(' ', 2));
    for (std::sregex_iterator it(names.begin(), names.end(), flag), end; it != end; ++it) {
      flags.insert((*it)[1]);
    }
  }
  return flags;
}

TEST(EveryCommandTest, AreAllFound) { EXPECT_GE(all_commands().size(), 30U); }

TEST(EveryCommandTest, NamesAnUnknownFlagTheNearestOfItsOwnAndItsHelp) {
  for (const Command& command : all_commands()) {
    const std::set<std::string> flags = flags_in(command.help);
    EXPECT_EQ(flags.count("help"), 1U) << command.shown();
    EXPECT_EQ(flags.count("quiet"), 1U) << command.shown();
    // One of its own if it has any.
    const auto own = std::find_if(flags.begin(), flags.end(), [](const std::string& flag) {
      return flag != "help" && flag != "quiet";
    });
    const std::string flag = own == flags.end() ? "quiet" : *own;
    const std::string miss = "--" + flag + flag.back();
    const CommandResult result = command.run(miss);
    EXPECT_EQ(result.exit_code, 2) << command.shown();
    EXPECT_THAT(result.errors, AllOf(HasSubstr("unknown flag '" + miss + "'"),
                                     HasSubstr("did you mean '--" + flag + "'?"),
                                     EndsWith("; see " + command.shown() + " --help\n")));
    EXPECT_EQ(result.output, "") << command.shown();
  }
}

TEST(EveryCommandTest, HasAnExampleAndTheShortFormsOfHabit) {
  for (const Command& command : all_commands()) {
    EXPECT_THAT(command.help, ContainsRegex("Examples?:\n  " + command.shown() + " "));
    EXPECT_THAT(command.help, HasSubstr("-q,--quiet"));
    if (flags_in(command.help).count("out") > 0) {
      EXPECT_THAT(command.help, HasSubstr("-o,--"));
    }
    if (flags_in(command.help).count("force") > 0) {
      EXPECT_THAT(command.help, HasSubstr("-f,--force"));
    }
  }
}

TEST(EveryCommandTest, CommonFlagsComeFirstInALongHelp) {
  for (const Command& command : all_commands()) {
    const std::set<std::string> flags = flags_in(command.help);
    if (flags.size() < 14) continue;
    const std::size_t options = command.help.find("\nOptions:\n");
    ASSERT_NE(options, std::string::npos) << command.shown();
    const std::size_t next_group = command.help.find("\n\n", options);
    for (const char* common : {"--out", "--quiet", "--threads"}) {
      if (flags.count(common + 2) == 0) continue;
      EXPECT_LT(command.help.find(common, options), next_group) << command.shown() << common;
    }
    EXPECT_NE(command.help.find("--", next_group), std::string::npos)
        << command.shown() << " is long but has one group";
  }
}

TEST(EveryProgramTest, HasAVersionAndNamesAnUnknownCommandAndItsHelp) {
  std::set<std::string> programs;
  for (const Command& command : all_commands()) {
    if (!programs.insert(command.program).second) continue;
    const std::string program = fs::path(command.program).filename().string();
    const std::string miss = command.name + command.name.back();
    const CommandResult result = run_command(command.program + " " + miss + " --threads 1");
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.errors, program + ": error: unknown command '" + miss + "'; did you mean '" +
                                 command.name + "'?; see " + program + " --help\n");
    EXPECT_THAT(run_command(command.program + " --version").output, HasSubstr(program + " "));
  }
}

class WhiteRoomTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    directory_ = new TestDirectory();
    const CommandResult packed =
        in_directory(RAYWALK_BUILD_LF " pack -q --frames " RAYWALK_TEST_ROOM
                                      "/poses.csv --distance " RAYWALK_TEST_ROOM "/dist");
    EXPECT_EQ(packed.exit_code, 0) << packed.errors;
    EXPECT_EQ(packed.output + packed.errors, "") << "quiet";
  }
  static void TearDownTestSuite() { delete directory_; }
  static CommandResult in_directory(const std::string& command) {
    return run_command("cd " + directory_->path().string() + " && " + command);
  }
  static std::string picture_at(const std::string& at) {
    const CommandResult result =
        in_directory(RAYWALK_RENDER " view white-room.lf --width 64 --method initial " + at);
    EXPECT_EQ(result.exit_code, 0) << at << ": " << result.errors;
    return read_file(*directory_ / "view.png");
  }

  static TestDirectory* directory_;
};
TestDirectory* WhiteRoomTest::directory_ = nullptr;

// Every fourth frame of the room at an eighth of its size, in a folder whose name has a space.
TEST_F(WhiteRoomTest, AllMakesARefinedRoomAndRepeatsNothing) {
  const fs::path hall = *directory_ / "my hall";
  make_directories(hall);
  std::vector<ListedFrame> rows;
  for (const Frame& frame : read_frame_list(fs::path(RAYWALK_TEST_ROOM) / "poses.csv")) {
    if (frame.path.stem().string().back() % 4 != 0) continue;
    rows.push_back({.file = frame.path.stem().string() + ".png", .position_m = frame.position_m});
    cv::Mat small;
    cv::resize(read_panorama(frame.path), small, {128, 64}, 0.0, 0.0, cv::INTER_AREA);
    write_image(hall / rows.back().file, small);
  }
  write_file_atomically(hall / "poses.csv", frame_list_text(rows));
  const std::string all = RAYWALK_BUILD_LF " all --frames 'my hall/poses.csv'";
  const CommandResult made = in_directory(all);
  ASSERT_EQ(made.exit_code, 0) << made.errors;
  const std::string next = "next: raywalk-render view 'my hall-refined.lf' --at ";
  ASSERT_THAT(made.output, HasSubstr(next));
  const std::string at = made.output.substr(made.output.find(next) + next.size());
  EXPECT_EQ(
      in_directory(RAYWALK_RENDER " view 'my hall-refined.lf' --out all.png --at " + at).exit_code,
      0);
  const CommandResult again = in_directory(all);
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_EQ(again.output, made.output);
  EXPECT_THAT(again.errors, AllOf(HasSubstr("packed before"), HasSubstr("estimated before"),
                                  HasSubstr("refined before")));
  rows.pop_back();
  write_file_atomically(hall / "poses.csv", frame_list_text(rows));
  const CommandResult other = in_directory(all);
  expect_one_error(other, 1, "my hall.lf");
  EXPECT_THAT(other.errors, HasSubstr("--force"));
  EXPECT_EQ(in_directory(all + " -f -q").exit_code, 0);
}

// The room is named after the folder of its frames.
TEST_F(WhiteRoomTest, ViewpointIsWrittenInAnyHabit) {
  const std::string centre = picture_at("--at 0,0");
  for (const char* at : {"--at 0 0", "--at '0, 0'", "--at=0 0"}) {
    EXPECT_EQ(picture_at(at), centre) << at;
  }
  const std::string aside = picture_at("--at=-0.1,-0.2");
  EXPECT_NE(aside, centre);
  EXPECT_EQ(picture_at("--at -0.1 -0.2"), aside);
  expect_one_error(in_directory(RAYWALK_RENDER " view white-room.lf --at 0"), 2, "--at is '0'");
}

TEST_F(WhiteRoomTest, ForceReplacesARoomOnlyByACompleteOneAndNothingElse) {
  const std::string pack = RAYWALK_BUILD_LF " pack --frames " RAYWALK_TEST_ROOM "/poses.csv ";
  const fs::path room = *directory_ / "white-room.lf";
  EXPECT_TRUE(fs::exists(room / "distances"));
  const CommandResult refused = in_directory(pack);
  expect_one_error(refused, 1, "exists already");
  EXPECT_THAT(refused.errors, HasSubstr("--force"));

  EXPECT_EQ(in_directory(pack + "-f --distance /no/such/place").exit_code, 1);
  EXPECT_TRUE(fs::exists(room / "distances")) << "kept, as the new room was not made";

  EXPECT_EQ(in_directory(pack + "-f").exit_code, 0);
  EXPECT_FALSE(fs::exists(room / "distances")) << "replaced by a room without distances";

  write_file_atomically(room / "notes.txt", "mine");
  expect_one_error(in_directory(pack + "-f"), 1, "notes.txt");
  EXPECT_EQ(read_file(room / "notes.txt"), "mine");
  fs::remove(room / "notes.txt");

  fs::create_directory(*directory_ / "photos");
  write_file_atomically(*directory_ / "photos" / "manifest.json", "{\"name\": \"my web page\"}");
  expect_one_error(in_directory(pack + "-f -o photos"), 1, "is not a room made by Raywalk");
  EXPECT_TRUE(fs::exists(*directory_ / "photos" / "manifest.json"));
}

TEST_F(WhiteRoomTest, QuietInfoPrintsOnlyTheJsonThatIsAskedFor) {
  EXPECT_EQ(in_directory(RAYWALK_BUILD_LF " info -q white-room.lf").output, "");
  EXPECT_THAT(in_directory(RAYWALK_BUILD_LF " info -q --json white-room.lf").output,
              testing::StartsWith("{"));
}

}  // namespace
}  // namespace raywalk
