// End-to-end test of raywalk-calibrate. RAYWALK_BUILD_LF, RAYWALK_CALIBRATE, RAYWALK_SIMULATE and
// RAYWALK_RENDER are the programs.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <regex>

#include "core/files/csv.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/files/sqlite_connection.h"
#include "core/panorama/srgb.h"
#include "core/session/session_schema.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

CommandResult calibrate(const std::string& arguments) {
  return run_command(fmt::format("{} {}", RAYWALK_CALIBRATE, arguments));
}

json json_of(const fs::path& file) { return json::parse(read_file(file)); }

// A square of lines in the virtual room with upright cameras; the frame list has a wrong attitude
// for each line.
class CalibrateTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    captured_ = new TestDirectory();
    write_file_atomically(
        *captured_ / "room.yaml",
        "grid:\n  spacing_mm: 200\n  overhang_share: 0.2\noutput:\n  width_px: 512\n");
    expect_success(run_command(fmt::format("{} room {} --out {} --every-distance 0 --truth-views 0",
                                           RAYWALK_SIMULATE, (*captured_ / "room.yaml").string(),
                                           capture().string())));
    const std::map<std::string, std::string> attitudes{{"x0", "0.8,-0.3,0.2"},
                                                       {"x1", "-0.6,0.2,0.4"},
                                                       {"z0", "0.4,0.5,-0.3"},
                                                       {"z1", "-0.6,-0.4,-0.3"}};
    std::string list = "file,x,y,z,yaw,pitch,roll\n", truth = list;
    for (const Frame& frame : read_frame_list(capture() / "poses.csv")) {
      const Eigen::Vector3d& at = frame.position_m;
      const std::string row = fmt::format("{},{},{},{},", frame.file, at.x(), at.y(), at.z());
      list += row + attitudes.at(frame.path.stem().string().substr(0, 2)) + "\n";
      truth += row + "0,0,0\n";
    }
    write_file_atomically(capture() / "poses.csv", list);
    write_file_atomically(capture() / "truth.csv", truth);
  }
  static void TearDownTestSuite() { delete captured_; }
  static fs::path capture() { return *captured_ / "room"; }

  // Into the test's directory.
  CommandResult run(const std::string& command, const std::string& options = "") const {
    return calibrate(
        fmt::format("{} {} --out {} {}", command, capture().string(), out().string(), options));
  }
  fs::path out() const { return directory_ / "calibration"; }
  void pack(const std::string& list, const std::string& room) const {
    expect_success(run_command(fmt::format("{} pack --frames {} --out {}", RAYWALK_BUILD_LF,
                                           (out() / list).string(), room)));
  }
  // Packs the frames before and after, and compares how their lines connect.
  void expect_a_better_connection() const {
    EXPECT_LT(connection_error("poses.csv", "after.lf"),
              0.9 * connection_error("before.csv", "before.lf"));
  }
  // Of a room of these frames at k = 90; NaN where it cannot be measured.
  double connection_error(const std::string& list, const std::string& room) const {
    const std::string path = (directory_ / room).string();
    pack(list, path);
    const CommandResult measured =
        run_command(fmt::format("{} connect-error {} --viewpoints 5", RAYWALK_RENDER, path));
    EXPECT_EQ(measured.exit_code, 0) << measured.errors;
    std::smatch row;
    const std::regex at_90(" 90 +rayspace360 +([0-9.]+) ");
    if (!std::regex_search(measured.output, row, at_90)) return std::nan("");
    return std::stod(row[1]);
  }

  static TestDirectory* captured_;
  TestDirectory directory_;
};
TestDirectory* CalibrateTest::captured_ = nullptr;

// Small faces have a third of the features, and take a third of the time.
constexpr const char* kAllOptions = "--cone-deg 20 --face-px 192";

TEST_F(CalibrateTest, WrongUsageIsExitCodeTwo) {
  expect_one_error(calibrate(""), 2, "subcommand");
  expect_one_error(calibrate("all"), 2, "input");
  expect_one_error(run("mask"), 2, "--cone-deg");
  expect_one_error(run("mask", "--cone-deg 90"), 2, "--cone-deg");
  expect_one_error(run("all", "--method guess"), 2, "--method");
  expect_one_error(run("all", "--redo dishes"), 2, "--redo");
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(CalibrateTest, InvalidInputIsNamed) {
  expect_one_error(calibrate("all /nowhere"), 1, "/nowhere: no such directory");
  expect_one_error(calibrate("all " + directory_.path().string()), 1, "neither a capture session");
  write_file_atomically(directory_ / "session.db", std::string("no database at all"));
  expect_one_error(calibrate("all " + directory_.path().string()), 1, "session.db");
  EXPECT_EQ(directory_.entries(), 1U);
}

// Every step of such a session was a segmentation fault.
TEST_F(CalibrateTest, SessionWithoutStationsIsRefusedByEveryStep) {
  const fs::path session = directory_ / "session";
  fs::create_directories(session);
  SqliteConnection(session / "session.db", SqliteAccess::kReadWrite)
      .execute(
          fmt::format("{}PRAGMA application_id = {}; PRAGMA user_version = {};"
                      "INSERT INTO session (id, created_utc_us, mode, camera, frames, bracket_ev, "
                      "config_text) VALUES (1, 0, 'stations', 'osc', 'panorama', '[0]', '')",
                      kSessionSchema, kSessionApplicationId, kSessionFormatVersion));
  for (const char* step : {"lens", "stitch", "mask --cone-deg 20", "poses", "rectify", "all"}) {
    expect_one_error(calibrate(std::string(step) + " --partial " + session.string()), 1,
                     "no stations");
  }
  EXPECT_FALSE(fs::exists(session / "calibration"));
}

TEST_F(CalibrateTest, FileNamesAreShownEscaped) {
  const CommandResult result = calibrate("all '/no\n\x1b[31m\xff'");
  EXPECT_EQ(result.errors,
            "raywalk-calibrate: error: /no\\n\\u001b[31m\\xff: no such directory; give a capture "
            "session, or a folder with poses.csv\n");
  const fs::path strange = directory_ / "out\n\x1b[31m\xff";
  const CommandResult masked =
      calibrate("mask --cone-deg 20 " + capture().string() + " --out '" + strange.string() + "'");
  EXPECT_EQ(masked.exit_code, 0) << masked.errors;
  EXPECT_THAT(masked.output, HasSubstr("out\\n\\u001b[31m\\xff/index.html\n"));
  EXPECT_EQ(masked.output.find('\x1b'), std::string::npos);
  json_of(strange / "mask.json");
  json_of(strange / "steps.json");
}

TEST_F(CalibrateTest, MissingEarlierStepsAreNamed) {
  expect_one_error(run("rectify"), 1, "run raywalk-calibrate poses first");
  EXPECT_THAT(run("stitch").output, HasSubstr("panoramas already"));
}

TEST_F(CalibrateTest, WithoutColmapTheAlternativesAreNamed) {
  const CommandResult result = run_command(fmt::format(
      "PATH= {} all {} --out {}", RAYWALK_CALIBRATE, capture().string(), out().string()));
  expect_one_error(result, 1, "rectify --poses");
  EXPECT_THAT(result.errors, HasSubstr("COLMAP"));
  EXPECT_FALSE(fs::exists(out() / "poses.json"));
  EXPECT_FALSE(fs::exists(out() / "calibration.json"));
}

TEST_F(CalibrateTest, DirectoryThatCannotBeWrittenIsNamed) {
  expect_one_error(calibrate(fmt::format("mask {} --cone-deg 20 --out {}", capture().string(),
                                         (capture() / "poses.csv/out").string())),
                   1, "poses.csv/out");
}

// Two neighbours have each other's names in the list.
TEST_F(CalibrateTest, ContradictionsAreNamedAndTheResultIsKept) {
  const fs::path listed = directory_ / "listed";
  fs::create_directories(listed);
  std::string rows = "file,x,y,z\n";
  std::vector<Frame> frames = read_frame_list(capture() / "poses.csv");
  const auto named = [&](const std::string& name) {
    return std::ranges::find(frames, name,
                             [](const Frame& one) { return one.path.stem().string(); });
  };
  std::swap(named("x1_002")->position_m, named("x1_003")->position_m);
  for (const Frame& frame : frames) {
    rows += fmt::format("{},{},{},{}\n", frame.path.string(), frame.position_m.x(),
                        frame.position_m.y(), frame.position_m.z());
  }
  write_file_atomically(listed / "poses.csv", rows);
  const CommandResult result = calibrate(fmt::format("all {} {}", listed.string(), kAllOptions));
  expect_one_error(result, 1, "not trustworthy");
  EXPECT_THAT(result.errors, AllOf(HasSubstr("x1_002"), HasSubstr("x1_003"),
                                   HasSubstr("lie at each other's listed places")));
  const json poses = json_of(listed / "calibration/calibration.json")["poses"];
  EXPECT_EQ(poses["trustworthy"], false);
  ASSERT_EQ(poses["contradictions"].size(), 1U);
  EXPECT_EQ(poses["contradictions"][0]["kind"], "exchanged");
  // The pictures are believed.
  for (const json& frame : poses["frames"]) {
    if (frame["name"] != "x1_002") continue;
    EXPECT_NEAR(frame["position_m"][0].get<double>(), named("x1_003")->position_m.x(), 0.01);
  }
  EXPECT_TRUE(fs::exists(listed / "calibration/index.html"));
}

TEST_F(CalibrateTest, RectifyWithExternalPoses) {
  expect_success(run("mask", "--cone-deg 20"));
  EXPECT_THAT(
      expect_success(run("rectify", "--poses " + (capture() / "truth.csv").string())).output,
      HasSubstr("raywalk-build-lf all --frames"));
  const std::vector<Frame> listed = read_frame_list(out() / "poses.csv");
  ASSERT_EQ(listed.size(), read_frame_list(capture() / "poses.csv").size());
  ASSERT_TRUE(listed[0].mask);
  EXPECT_TRUE(fs::equivalent(listed[0].path, capture() / "capture" / listed[0].path.filename()));
  EXPECT_EQ(json_of(out() / "calibration.json")["rectify"], json_of(out() / "rectify.json"));
  EXPECT_TRUE(fs::exists(out() / "index.html"));
}

TEST_F(CalibrateTest, MasksAndHeldOutFramesReachTheRoom) {
  const fs::path folder = directory_ / "listed";
  fs::create_directories(folder);
  std::string list = "file,x,y,z,mask\n", truth = list;
  cv::Mat mask(256, 512, CV_8UC1, cv::Scalar(255));
  mask.rowRange(192, 256).setTo(0);
  for (const Frame& frame : read_frame_list(capture() / "poses.csv")) {
    const std::string name = frame.path.stem().string();
    const Eigen::Vector3d& at = frame.position_m;
    const bool held_out = name == "x0_003";
    const std::string own = held_out || name == "x0_002" ? name + "_mask.png" : "";
    if (!own.empty()) write_image(folder / own, mask);
    (held_out ? truth : list) +=
        fmt::format("{},{},{},{},{}\n", frame.path.string(), at.x(), at.y(), at.z(), own);
  }
  write_file_atomically(folder / "poses.csv", list);
  write_file_atomically(folder / "gt.csv", truth);
  const CommandResult masked =
      calibrate(fmt::format("mask {} --out {}", folder.string(), out().string()));
  ASSERT_EQ(masked.exit_code, 0) << masked.errors;
  EXPECT_THAT(masked.errors, HasSubstr("30 of 31 frames have no mask"));
  EXPECT_THAT(masked.output, HasSubstr("14.64 % in the 2 of 32 frames with a mask of their own"));
  expect_success(calibrate(fmt::format("rectify {} --out {} --poses {}", folder.string(),
                                       out().string(), (capture() / "truth.csv").string())));
  const std::vector<Frame> stations = read_frame_list(out() / "poses.csv");
  const std::vector<Frame> views = read_frame_list(out() / "gt.csv");
  EXPECT_EQ(stations.size(), 31U);
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].path.stem(), "x0_003");
  ASSERT_TRUE(views[0].mask);
  EXPECT_NEAR(cv::countNonZero(read_mask(*views[0].mask, {512, 256})), 192 * 512, 3 * 512);
  const std::string room = (directory_ / "room.lf").string();
  pack("poses.csv", room);
  const CommandResult info = run_command(fmt::format("{} info {} --json", RAYWALK_BUILD_LF, room));
  EXPECT_NEAR(json::parse(info.output)["masked_share"].get<double>(), 0.1464 / 31, 1e-3);
  write_image(folder / "x0_003_mask.png", cv::Mat(128, 256, CV_8UC1, cv::Scalar(255)));
  for (const char* step : {"mask", "poses", "rectify", "all"}) {
    expect_one_error(
        calibrate(fmt::format("{} {} --out {}", step, folder.string(), out().string())), 1,
        "gt.csv:2: ");
  }
}

TEST_F(CalibrateTest, AllStepsAlignTheLinesAndAreNotRepeated) {
  const CommandResult first = run("all", kAllOptions);
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  EXPECT_THAT(first.output, Not(HasSubstr("done earlier")));
  EXPECT_THAT(first.output, ::testing::ContainsRegex(
                                "poses: 32 of 32 stations posed.* largest error at "
                                "the 4 intersections [0-9.]+ mm and [0-9.]+ px .W = 4096., by "
                                "[0-9.]+ mm and [0-9.]+ degrees corrected"));
  EXPECT_THAT(first.output, HasSubstr("rectify: 32 frames\n"));
  EXPECT_THAT(first.output, HasSubstr("\ntrustworthy; see " + (out() / "index.html").string()));
  EXPECT_THAT(first.errors, ::testing::ContainsRegex("matching features: [0-9]+ of [0-9]+ pairs"));
  const json calibration = json_of(out() / "calibration.json");
  EXPECT_EQ(calibration["trustworthy"], true);
  EXPECT_EQ(calibration["poses"]["intersections"].size(), 4U);
  for (const json& intersection : calibration["poses"]["intersections"]) {
    EXPECT_GT(intersection["correction_deg"], 0.4);
    EXPECT_LT(intersection["rotation_px"], 2.0);
  }
  // In truth all attitudes are equal. A common rotation is not observable.
  const auto spread = [&](const char* angle) {
    double least = 360.0, most = -360.0;
    for (const json& frame : calibration["poses"]["frames"]) {
      least = std::min(least, frame[angle].get<double>());
      most = std::max(most, frame[angle].get<double>());
    }
    return most - least;
  };
  EXPECT_LT(spread("yaw_deg"), 0.5);    // of 1.4 in the list
  EXPECT_LT(spread("pitch_deg"), 0.5);  // of 0.9
  EXPECT_LT(spread("roll_deg"), 0.5);   // of 0.7
  expect_a_better_connection();
  EXPECT_THAT(read_file(out() / "index.html"),
              AllOf(HasSubstr("\"kind\":\"calibration\""), HasSubstr("x0 × z0")));

  const auto made = fs::last_write_time(out() / "poses.csv");
  const CommandResult second = expect_success(run("all", kAllOptions));
  for (const char* step : {"mask", "poses", "rectify"}) {
    EXPECT_THAT(second.output, ::testing::ContainsRegex(std::string(step) + ".*done earlier"));
  }
  EXPECT_EQ(fs::last_write_time(out() / "poses.csv"), made);
}

}  // namespace
}  // namespace raywalk
