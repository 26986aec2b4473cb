// End-to-end test of raywalk-capture, against the simulated rig in a process of its own.
#include <gmock/gmock.h>
#include <httplib.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/sqlite_connection.h"
#include "core/files/test_support.h"
#include "tests/end_to_end/run_command.h"
#include "tests/end_to_end/simulated_rig_process.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;

// The default plan: 4 lines of 3 stations, 500 mm apart.
constexpr std::size_t kStations = 12;

class CaptureCommandTest : public ::testing::Test {
 protected:
  CaptureCommandTest() { files_.directory = directory_.path(); }

  void start_rig() {
    files_.write();
    rig_.emplace(files_);
    url_ = addresses()["camera_url"].get<std::string>();
  }
  json addresses() const { return json::parse(read_file(rig_->directory() / "rig.json")); }
  std::string session() const { return (directory_ / "session").string(); }
  std::string with_rig() const {
    return files_.capture().string() + " --rig " + rig_->directory().string();
  }
  CommandResult capture(const std::string& arguments) const {
    return run_command(std::string(RAYWALK_CAPTURE) + " " + arguments);
  }
  CommandResult run() const { return capture("run " + with_rig() + " --session " + session()); }
  std::unique_ptr<BackgroundProcess> run_in_background() const {
    return std::make_unique<BackgroundProcess>(
        std::vector<std::string>{RAYWALK_CAPTURE, "run", files_.capture().string(), "--rig",
                                 rig_->directory().string(), "--session", session()},
        directory_ / "run.log");
  }
  std::string run_log() const { return read_file(directory_ / "run.log"); }
  void wait_for_moves(int moves, BackgroundProcess* process) const {
    const int before = rig_state()["moves"];
    while (rig_state()["moves"] < before + moves) ASSERT_FALSE(process->has_ended()) << run_log();
  }
  // A run in which the rig fails during a move; its exit code.
  int run_with_fault(const json& fault) const {
    auto process = run_in_background();
    wait_for_moves(3, process.get());
    rig_fault(fault);
    return process->wait();
  }
  json rig_state() const { return json::parse(httplib::Client(url_).Get("/rig/state")->body); }
  void rig_fault(const json& fault) const {
    const auto reply = httplib::Client(url_).Post("/rig/fault", fault.dump(), "application/json");
    ASSERT_EQ(reply->status, 200) << reply->body;
  }
  bool is_rig_reachable() const {
    return fs::exists(rig_->directory() / "slider") && httplib::Client(url_).Get("/rig/state");
  }
  void mend_rig() const { httplib::Client(url_).Post("/rig/mend", "", "application/json"); }

  CsvTable exported_poses() const {
    return CsvTable::read(session() + "/poses.csv", {"file", "x", "y", "z", "line"}, {});
  }
  // What the rig knows of every picture.
  CsvTable true_poses() const {
    return CsvTable::read(rig_->directory() / "truth" / "true_poses.csv",
                          {"file", "line", "x", "y", "z", "yaw", "pitch", "roll"}, {});
  }
  // All invariants of a finished session.
  void expect_finished_session() const {
    expect_success(capture("verify " + session()));
    expect_success(capture("export " + session()));
    const CsvTable poses = exported_poses();
    std::set<std::string> frames;
    for (std::size_t row = 0; row < poses.rows(); ++row) frames.insert(poses.text(row, "file"));
    EXPECT_EQ(poses.rows(), kStations);
    EXPECT_EQ(frames.size(), kStations);
    EXPECT_EQ(integrity(), "ok");
  }
  std::string integrity() const {
    return SqliteConnection(session() + "/session.db", SqliteAccess::kReadWrite)
        .text("PRAGMA integrity_check");
  }
  // Checksum of every frame stored so far.
  std::map<std::string, std::string> frame_sums() const {
    std::map<std::string, std::string> sums;
    if (!fs::exists(session() + "/frames")) return sums;
    sums = checksums_of_files(session() + "/frames");
    std::erase_if(sums, [](const auto& each) {
      return each.first.starts_with(".") || !each.first.ends_with(".jpg");
    });
    return sums;
  }

  TestDirectory directory_;
  RehearsalFiles files_;
  std::optional<SimulatedRigProcess> rig_;
  std::string url_;
};

// A rail half as long as the lines, placed twice for each; two sessions, one line in both.
TEST_F(CaptureCommandTest, LinesCapturedApartBecomeOneSession) {
  files_.spacing_mm = 250.0;
  files_.high_limit_mm = 600.0;
  files_.placements_per_line = 2;
  files_.more_rig = "rail:\n  placing_spread_mm: 2\n";
  start_rig();
  const std::string first = (directory_ / "first").string();
  const std::string second = (directory_ / "second").string();
  EXPECT_THAT(
      expect_success(capture("run " + with_rig() + " --lines x0,z0 --session " + first)).output,
      HasSubstr("all 10 stations of 2 lines are captured"));
  ASSERT_EQ(capture("run " + with_rig() + " --lines z0-z1,x1 --session " + second).exit_code, 0);
  expect_one_error(capture("merge " + first + " " + second + " --out " + session()), 1,
                   "line z0 is captured in");
  expect_success(capture("merge " + first + " " + second + " --replace --out " + session()));
  EXPECT_EQ(capture("verify " + session()).exit_code, 0);
  EXPECT_THAT(run().output, HasSubstr("all 20 stations of 4 lines are captured"));
  ASSERT_EQ(capture("export " + session()).exit_code, 0);
  // Every frame is at its place, with the errors of its own placement.
  const CsvTable poses = exported_poses();
  ASSERT_EQ(poses.rows(), 20u);
  const CsvTable truth = true_poses();
  std::set<std::string> placements;
  for (std::size_t row = 0; row < truth.rows(); ++row) placements.insert(truth.text(row, "line"));
  EXPECT_THAT(placements, IsSupersetOf({"x0", "x0-2", "x1-2", "z1-2"}));
  for (std::size_t i = 0; i < poses.rows(); ++i) {
    bool found = false;
    for (std::size_t row = 0; row < truth.rows() && !found; ++row) {
      found = std::hypot(poses.number(i, "x") - truth.number(row, "x"),
                         poses.number(i, "z") - truth.number(row, "z")) < 0.02;
    }
    EXPECT_TRUE(found) << poses.text(i, "file");
  }
}

TEST_F(CaptureCommandTest, ASessionFromTheFirstMoveToTheFrameList) {
  files_.more_rig = "rail:\n  placing_spread_mm: 2\n";
  start_rig();
  EXPECT_THAT(expect_success(capture("check " + with_rig())).output,
              AllOf(HasSubstr("slider  ok"), HasSubstr("camera  ok"), HasSubstr("disk    ok"),
                    HasSubstr("leadshine-pr0")));
  EXPECT_THAT(expect_success(run()).output, HasSubstr("all 12 stations of 4 lines are captured"));
  expect_finished_session();
  EXPECT_THAT(capture("status " + session()).output, HasSubstr("12 of 12 stations captured"));

  // The true positions recorded by the rig differ by the errors of the rail.
  const CsvTable truth = true_poses(), poses = exported_poses();
  ASSERT_GE(truth.rows(), poses.rows());
  const std::size_t first = truth.rows() - poses.rows();  // rows before it: metering
  for (std::size_t i = 0; i < poses.rows(); ++i) {
    for (const char* axis : {"x", "y", "z"}) {
      EXPECT_NEAR(poses.number(i, axis), truth.number(first + i, axis), 0.02);
    }
  }
}

TEST_F(CaptureCommandTest, KilledAtRandomMomentsLosesAndOverwritesNothing) {
  start_rig();
  const char* asked = std::getenv("RAYWALK_KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 20;
  std::mt19937 random(7);
  std::uniform_int_distribution<int> delay_ms(0, 900);
  int killed_in_work = 0;
  for (int i = 0; i < kills; ++i) {
    if (frame_sums().size() >= kStations) {  // nearly finished: check it and start another
      ASSERT_EQ(run().exit_code, 0);
      expect_finished_session();
      fs::remove_all(session());
    }
    const auto before = frame_sums();
    auto process = run_in_background();
    std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms(random)));
    process->signal(SIGKILL);
    if (process->wait() == 128 + SIGKILL) ++killed_in_work;
    ASSERT_THAT(frame_sums(), IsSupersetOf(before)) << "a frame is gone or was overwritten";
    if (fs::exists(fs::path(session()) / "session.db")) {
      ASSERT_EQ(integrity(), "ok");
    }
  }
  EXPECT_GT(killed_in_work, kills / 4);
  expect_success(run());
  expect_finished_session();
  EXPECT_GE(rig_state()["visited_mm"][0].get<double>(), -1.0);
  EXPECT_LE(rig_state()["visited_mm"][1].get<double>(), 2100.0);
}

TEST_F(CaptureCommandTest, SignalsStopTheSliderAndTheSessionResumes) {
  files_.speed_mm_s = 600.0;
  start_rig();
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    auto process = run_in_background();
    ASSERT_NO_FATAL_FAILURE(wait_for_moves(3, process.get()));
    process->signal(number);
    process->signal(number);  // a second signal: the slider must still be stopped
    EXPECT_EQ(process->wait(), 130);
    EXPECT_FALSE(rig_state()["moving"].get<bool>());
    EXPECT_THAT(run_log(), HasSubstr("the same command resumes"));
  }
  expect_success(run());
  expect_finished_session();
}

TEST_F(CaptureCommandTest, ALostFrameIsNeverCalledCaptured) {
  files_.speed_mm_s = 2000.0;
  start_rig();
  ASSERT_EQ(run().exit_code, 0);
  const fs::path frame = fs::path(session()) / "frames/x0_001.jpg";
  fs::remove(frame);
  EXPECT_THAT(capture("status " + session()).output,
              AllOf(HasSubstr("11 of 12 stations captured, 1 lost"),
                    HasSubstr("lost: frames/x0_001.jpg"), HasSubstr("--give-up")));
  for (const CommandResult& refused : {capture("export " + session()), run()}) {
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.errors, AllOf(HasSubstr("frames/x0_001.jpg"), HasSubstr("--give-up")));
    EXPECT_EQ(refused.output, "");
  }
  EXPECT_EQ(capture("verify " + session()).exit_code, 1);
  EXPECT_EQ(capture("verify --give-up " + session()).exit_code, 0);
  EXPECT_THAT(capture("status " + session()).output, HasSubstr("resumes at station x0_001"));
  EXPECT_THAT(run().output, HasSubstr("all 12 stations"));
  expect_finished_session();
}

TEST_F(CaptureCommandTest, WithoutAPlaceUrlTheOperatorIsPrompted) {
  start_rig();
  // A copy of the configuration with the rig's devices but without place_url.
  std::string yaml = read_file(files_.capture());
  yaml.replace(yaml.find("none"), 4, addresses()["slider"].get<std::string>());
  yaml.replace(yaml.find("http://127.0.0.1"), 16, url_);
  const fs::path config = directory_ / "by-hand.yaml";
  std::ofstream(config) << yaml;
  const std::string command =
      std::string(RAYWALK_CAPTURE) + " run " + config.string() + " --session " + session();
  const CommandResult unattended = run_command(command);
  EXPECT_EQ(unattended.exit_code, 3);
  EXPECT_THAT(unattended.errors, AllOf(HasSubstr("line x0"), HasSubstr("--yes")));
  EXPECT_THAT(expect_success(run_command("printf '\\n\\n\\n\\n' | " + command)).errors,
              AllOf(HasSubstr("Line z1 (4 of 4)"), HasSubstr("press Enter")));
}

TEST_F(CaptureCommandTest, ADryRunMovesWithoutTakingPictures) {
  start_rig();
  EXPECT_THAT(expect_success(capture("run " + with_rig() + " --dry-run")).output,
              HasSubstr("settled at all 12 stations"));
  EXPECT_EQ(rig_state()["pictures"], 0);
  EXPECT_FALSE(fs::exists(session()));
}

TEST_F(CaptureCommandTest, ManualMovesStayWithinTheSoftLimits) {
  start_rig();
  EXPECT_THAT(capture("jog " + with_rig() + " --mm 10").errors, HasSubstr("raywalk-capture home"));
  EXPECT_EQ(capture("home " + with_rig()).exit_code, 0);
  EXPECT_THAT(capture("jog " + with_rig() + " --mm 150.5").output, HasSubstr("at 150.5"));
  for (const char* mm : {"-151", "2000", "nan", "1e300"}) {
    EXPECT_NE(capture("jog " + with_rig() + " --mm " + mm).exit_code, 0) << mm;
  }
  EXPECT_NEAR(rig_state()["carriage_mm"].get<double>(), 150.5, 0.1);
  EXPECT_EQ(capture("stop " + with_rig()).exit_code, 0);
}

TEST_F(CaptureCommandTest, EachMissingDeviceIsNamed) {
  files_.write();
  const std::string check = "check " + files_.capture().string();
  EXPECT_THAT(capture(check).output, AllOf(HasSubstr("slider  FAILS"), HasSubstr("camera  FAILS"),
                                           HasSubstr("disk    ok")));
  EXPECT_EQ(capture(check).exit_code, 1);
  EXPECT_THAT(capture(check + " --rig nowhere").errors, HasSubstr("raywalk-simulate rig"));
}

TEST_F(CaptureCommandTest, PlanWritesAReportOnDemandAndReplacesOnlySuch) {
  files_.write();
  const std::string report = (directory_ / "plan.html").string();
  const std::string plan = "plan " + files_.capture().string();
  EXPECT_THAT(expect_success(capture(plan + " --report " + report)).output,
              HasSubstr("4 lines, 12 stations"));
  EXPECT_THAT(read_file(report), HasSubstr("\"kind\":\"plan\""));
  EXPECT_EQ(json::parse(capture(plan + " --json").output)["grid"]["stations"], 12);
  EXPECT_EQ(capture(plan + " -o " + report).exit_code, 0);
  write_file_atomically(report, "notes");
  EXPECT_THAT(capture(plan + " -o " + report).errors, HasSubstr("is no report of Raywalk's"));
  EXPECT_EQ(read_file(report), "notes");
}

struct FaultCase {
  const char* name;
  json fault;
  const char* says;  // a pattern of the error line
};

class CaptureFaultTest : public CaptureCommandTest,
                         public ::testing::WithParamInterface<FaultCase> {};

TEST_P(CaptureFaultTest, PausesWithAnErrorLineAndResumesAfterRepair) {
  files_.speed_mm_s = 2000.0;
  files_.more_capture = "  shots: 2\n";
  start_rig();
  EXPECT_EQ(run_with_fault(GetParam().fault), 3) << run_log();
  const std::string log = run_log();
  const std::string line = log.substr(log.rfind("raywalk-capture: error:"));
  EXPECT_THAT(line, AllOf(HasSubstr("x0"), HasSubstr(";"), HasSubstr("the same command resumes"),
                          ContainsRegex(GetParam().says)));
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
  mend_rig();
  // A cut link and a camera that was down recover by themselves; a blocked drive must be homed.
  for (int i = 0; i < 1000 && !is_rig_reachable(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  expect_success(run());
  expect_finished_session();
}

INSTANTIATE_TEST_SUITE_P(
    Faults, CaptureFaultTest,
    // The fault may occur before or after the carriage starts to move.
    ::testing::Values(
        FaultCase{"Stall", {{"kind", "stall"}}, "does not move|stalled"},
        // A drive may also end the move at the switch by itself.
        FaultCase{"LimitSwitch", {{"kind", "high-limit"}}, "does not move|stalled|off its target"},
        FaultCase{"Cut", {{"kind", "cut"}}, "stop"},
        FaultCase{"FeedbackJump", {{"kind", "feedback-jump"}, {"amount", 30.0}}, "mm"},
        FaultCase{"Busy", {{"kind", "busy"}}, "camera.*busy"},
        FaultCase{"CardFull", {{"kind", "card-full"}, {"for_ms", 60000}}, "card"},
        FaultCase{"WebPage", {{"kind", "web-page"}, {"for_ms", 60000}}, "web page"},
        FaultCase{"CameraDown", {{"kind", "down"}, {"for_ms", 3000}}, "127.0.0.1"}),
    [](const ::testing::TestParamInfo<FaultCase>& param) { return param.param.name; });

TEST_F(CaptureCommandTest, AnAlarmIsNamedAndMustBeClearedManually) {
  files_.speed_mm_s = 2000.0;
  start_rig();
  EXPECT_EQ(run_with_fault({{"kind", "alarm"}, {"amount", 33}}), 3);
  EXPECT_THAT(run_log(), AllOf(HasSubstr("alarm"), HasSubstr("33")));
  EXPECT_NE(capture("check " + with_rig()).exit_code, 0);
}

}  // namespace
}  // namespace raywalk
