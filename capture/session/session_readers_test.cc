// What status, verify and export say of a session.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <vector>

#include "capture/plan/line_selection.h"
#include "capture/session/merge_sessions.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/geometry/grid.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ContainsRegex;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

// 15 stations: 4 lines of a cell, and one for validation.
class SessionReadersTest : public SessionCase {
 protected:
  SessionReadersTest() : SessionCase(test_plan(true)) {}

  nlohmann::json status() const { return capture_.status(); }
  std::string next_step() const { return status()["next_step"]; }
  std::string write(const ExportOptions& options) {
    SessionReader reader(capture_.directory);
    return export_session(&reader, options);
  }
  std::string refusal(const ExportOptions& options) {
    return error_of([&] { write(options); });
  }
  CsvTable table(const std::string& name) {
    return CsvTable::read(capture_.directory / name, {"file", "x", "y", "z"}, {"line"});
  }
};

TEST_F(SessionReadersTest, SeeWhatARunCommitsWhileItRuns) {
  const std::unique_ptr<Session> session = capture_.open();
  SessionReader reader(capture_.directory);
  EXPECT_THAT(reader.contents().frames, IsEmpty());
  capture_.capture_missing(session.get(), 2);
  EXPECT_EQ(reader.contents().frames.size(), 2U);
  EXPECT_TRUE(reader.contents().stations[1].shot);
  EXPECT_FALSE(reader.contents().stations[2].shot);
}

TEST_F(SessionReadersTest, StatusOfAnEmptySessionHasNoTimes) {
  capture_.open();
  const nlohmann::json empty = status();
  EXPECT_EQ(empty["stations"], 15);
  EXPECT_EQ(empty["captured"], 0);
  EXPECT_TRUE(empty["time_left_s"].is_null());
  EXPECT_TRUE(empty["times"]["own_ms"].is_null());
  EXPECT_THAT(next_step(), AllOf(HasSubstr("run CONFIG"), EndsWith("x0_000")));
}

TEST_F(SessionReadersTest, StatusCountsStationsAndTimeLeftWithoutBreaks) {
  const std::unique_ptr<Session> session = capture_.open();
  capture_.capture_missing(session.get(), 4);
  const nlohmann::json half = status();
  EXPECT_EQ(half["lines"].size(), 5U);
  EXPECT_EQ(half["lines"][0]["captured"], 3);
  EXPECT_EQ(half["lines"][4]["id"], "v0");
  EXPECT_THAT(next_step(), EndsWith("x1_001"));
  EXPECT_THAT(
      status_text(half),
      AllOf(HasSubstr("4 of 15 stations captured\n"), HasSubstr("x1        1 of 3 captured"),
            HasSubstr("0 of 3 captured  (validation)\n"), HasSubstr("about 28 s")));
  capture_.clock.sleep(std::chrono::hours(8));
  capture_.capture_missing(session.get(), 4);
  EXPECT_NEAR(status()["time_left_s"].get<double>(), 2.5 * (15 - 8), 1e-6);
  capture_.capture_missing(session.get());
  EXPECT_EQ(next_step(), "raywalk-capture export " + capture_.directory.string());
  EXPECT_EQ(status()["time_left_s"], 0.0);
}

TEST_F(SessionReadersTest, StatusHasMediansAndTheProgramsOwnTime) {
  const std::unique_ptr<Session> session = capture_.open();
  for (const double own_ms : {5.0, 7.0, 6.0, 100.0, 4.0}) {
    capture_.own_ms = own_ms;
    capture_.capture_missing(session.get(), 1);
  }
  EXPECT_THAT(
      status_text(status()),
      HasSubstr("median station: moving 1200 ms, settling 300 ms, exposing 800 ms, transfer "
                "150 ms, the program itself 6.0 ms (95 % within 100.0 ms)\n"));
}

TEST_F(SessionReadersTest, StatusCountsFaultsAndShowsTheLastEventsOldestFirst) {
  const std::unique_ptr<Session> session = capture_.open();
  for (const std::string fault : {"stall", "busy", "stall"}) {
    session->fail_attempt(session->begin_attempt("x0_000", 50.0), fault, "what happened");
  }
  for (int i = 0; i < 8; ++i) session->record_event("line-placed", fmt::format("line {}", i));
  EXPECT_EQ(status()["faults"], (nlohmann::json{{"stall", 2}, {"busy", 1}}));
  EXPECT_EQ(status()["lines"][0]["attempts"], 3);
  EXPECT_EQ(status()["captured"], 0);
  const std::string text = status_text(status());
  EXPECT_THAT(text, AllOf(HasSubstr("failed attempts: busy 1, stall 2"),
                          HasSubstr("3 further attempts"), Not(HasSubstr("line 2"))));
  EXPECT_LT(text.find("line 3"), text.find("line 7"));
  EXPECT_THAT(text, HasSubstr("2026-01-01 00:00:00 UTC  line-placed: line 7"));
}

TEST_F(SessionReadersTest, PicturesOnTheCardAreToBeImported) {
  capture_.config.camera.kind = CameraKind::kGpio;
  capture_.capture_missing(capture_.open().get());
  EXPECT_EQ(status()["exposed"], 15);
  EXPECT_THAT(next_step(), HasSubstr("import"));
  EXPECT_THAT(status_text(status()), HasSubstr("15 on the camera's card"));
  EXPECT_THAT(refusal({}), HasSubstr("pictures of 15 not imported"));
  EXPECT_THAT(refusal({.partial = true}), HasSubstr("nothing to export"));
}

TEST_F(SessionReadersTest, StatusNamesEachStepOfAVideo) {
  capture_.config.run.mode = CaptureMode::kVideo;
  const std::unique_ptr<Session> session = capture_.open();
  const JournalSample sample{capture_.clock.wall_now(), 50.0};
  session->record_journal("x0", {&sample, 1});
  EXPECT_THAT(next_step(), EndsWith("records line x1"));
  EXPECT_TRUE(status()["lines"][0]["recorded"].get<bool>());
  for (const std::string line : {"x1", "z0", "z1", "v0"}) {
    session->record_journal(line, {&sample, 1});
  }
  EXPECT_THAT(next_step(), HasSubstr("--video"));
}

TEST_F(SessionReadersTest, VerifyListsFilesOfNoStationWithoutAFault) {
  capture_.capture_missing(capture_.open().get());
  EXPECT_THAT(capture_.verify().leftover, IsEmpty());
  std::ofstream(capture_.directory / "frames/x0_001_a2.jpg") << "left";
  const SessionVerification verification = capture_.verify();
  EXPECT_TRUE(verification.is_whole());
  EXPECT_EQ(verification.frames, 15);
  EXPECT_EQ(verification.bytes,
            15 * static_cast<std::int64_t>(test_picture("x0_000 0").bytes.size()));
  EXPECT_THAT(verification_text(verification), HasSubstr("frames/x0_001_a2.jpg: belongs to no"));
}

TEST_F(SessionReadersTest, ExportWritesAGridWithItsCellAndGroundTruth) {
  capture_.off_mm = 0.5;
  capture_.capture_missing(capture_.open().get());
  EXPECT_THAT(write({}),
              AllOf(HasSubstr("12 frames on 4 lines"), HasSubstr("3 ground-truth views")));
  const CsvTable poses = table("poses.csv");
  std::vector<StationPose> stations;
  for (std::size_t row = 0; row < poses.rows(); ++row) {
    EXPECT_TRUE(fs::is_regular_file(capture_.directory / poses.text(row, "file")));
    stations.push_back({poses.text(row, "file"),
                        {poses.number(row, "x"), poses.number(row, "y"), poses.number(row, "z")},
                        "",
                        poses.text(row, "line")});
  }
  ASSERT_EQ(stations.size(), 12U);
  EXPECT_EQ(stations[0].line, "x0");
  const Grid grid = find_grid(stations, {});
  EXPECT_EQ(grid.lines.size(), 4U);
  EXPECT_EQ(grid.cells.size(), 1U);
  const CsvTable truth = table("gt.csv");
  ASSERT_EQ(truth.rows(), 3U);
  EXPECT_EQ(truth.text(0, "file"), "frames/v0_000.jpg");
  // Along the line by the feedback, across it as planned.
  EXPECT_LT((stations[0].position_m - Eigen::Vector3d(-0.7495, 0.0, -0.5)).norm(), 1e-9);
  EXPECT_LT((stations[11].position_m - Eigen::Vector3d(0.5, 0.0, 0.7505)).norm(), 1e-9);
  EXPECT_NEAR(truth.number(0, "x"), -0.2495, 1e-9);
  // The same again takes its place.
  const std::string first = read_file(capture_.directory / "poses.csv");
  write({});
  EXPECT_EQ(read_file(capture_.directory / "poses.csv"), first);
}

TEST_F(SessionReadersTest, ExportOfAnUnfinishedSessionHasToBeAskedFor) {
  capture_.capture_missing(capture_.open().get(), 7);
  EXPECT_THAT(refusal({}),
              AllOf(HasSubstr("8 of 15 stations"), HasSubstr("z0_001"), HasSubstr("--partial")));
  EXPECT_FALSE(fs::exists(capture_.directory / "poses.csv"));
  EXPECT_THAT(write({.partial = true}), HasSubstr("left out: 8 of 15 stations"));
  EXPECT_EQ(table("poses.csv").rows(), 7U);
  EXPECT_FALSE(fs::exists(capture_.directory / "gt.csv"));  // no line of it is captured yet
}

TEST_F(SessionReadersTest, ExportChoosesAnExposureOfTheBracket) {
  capture_.config.camera.exposure.bracket_ev = {0.0, -2.0};
  capture_.capture_missing(capture_.open().get());
  for (const auto& [exposure, file] : {std::pair{1, "x0_000_e1.jpg"}, std::pair{0, "x0_000.jpg"}}) {
    write({.exposure = exposure});
    EXPECT_EQ(table("poses.csv").rows(), 12U);
    EXPECT_EQ(table("poses.csv").text(0, "file"), std::string("frames/") + file);
  }
  EXPECT_THROW(write({.exposure = 2}), UsageError);
  EXPECT_THAT(refusal({.exposure = -1}), HasSubstr("--exposure takes 0 to 1"));
}

TEST_F(SessionReadersTest, ExportOfFisheyePicturesHasToBeAskedFor) {
  capture_.config.camera.frames = FrameKind::kDualFisheye;
  capture_.capture_missing(capture_.open().get());
  EXPECT_THAT(refusal({}), AllOf(HasSubstr("raywalk-calibrate"), HasSubstr("--unstitched")));
  EXPECT_NO_THROW(write({.unstitched = true}));
}

// Checks docs/session.md against a real session: every column is explained, every example runs.
class SessionDocsTest : public SessionCase {
 protected:
  SessionDocsTest() : SessionCase(test_plan()) {
    const std::unique_ptr<Session> session = capture_.open();
    session->record_event("run-started", "a slider, a camera");
    session->record_event("merged", "x0: 3 stations of monday");
    session->fail_attempt(session->begin_attempt("x0_000", 50.0), "stall", "it stood still");
    capture_.capture_missing(session.get());
    const JournalSample samples[] = {{capture_.clock.wall_now(), 50.0},
                                     {capture_.clock.wall_now() + std::chrono::seconds(1), 70.0}};
    session->record_journal("x0", samples);
  }

  // What the group of a pattern holds at each of its places in a text.
  static std::vector<std::string> all_in(const std::string& text, const std::string& pattern) {
    const std::regex regex(pattern);
    return {std::sregex_token_iterator(text.begin(), text.end(), regex, 1), {}};
  }

  // Table -> the names in backquotes in the first cell of its rows.
  std::map<std::string, std::set<std::string>> documented_columns() const {
    std::map<std::string, std::set<std::string>> columns;
    std::string table;
    std::istringstream lines(docs_);
    for (std::string line; std::getline(lines, line);) {
      const auto names = all_in(line.substr(0, line.find(" | ")), "`([a-z0-9_]+)`");
      if (line.starts_with("### `")) table = names.at(0);
      if (line.starts_with("## ")) table.clear();
      if (table.empty() || !line.starts_with("| `")) continue;
      columns[table].insert(names.begin(), names.end());
    }
    return columns;
  }

  std::string docs_ = read_file(RAYWALK_DOCS "/session.md");
};

TEST_F(SessionDocsTest, EveryExampleReturnsRows) {
  SqliteConnection connection = open_session_to_read(capture_.directory);
  const std::vector<std::string> queries = all_in(docs_, "```sql\n([^`]*)```");
  ASSERT_THAT(queries, SizeIs(9));
  for (const std::string& query : queries) {
    SqliteStatement statement(&connection, query);
    EXPECT_TRUE(statement.step()) << query;
    EXPECT_FALSE(statement.is_null(0)) << query;
  }
}

TEST_F(SessionDocsTest, ExplainsExactlyTheExistingColumns) {
  SqliteConnection connection = open_session_to_read(capture_.directory);
  SqliteStatement row(&connection,
                      "SELECT sqlite_master.name, columns.name FROM sqlite_master, "
                      "pragma_table_info(sqlite_master.name) AS columns "
                      "WHERE sqlite_master.type IN ('table', 'view')");
  std::map<std::string, std::set<std::string>> columns;
  while (row.step()) columns[row.text(0)].insert(row.text(1));
  EXPECT_EQ(documented_columns(), columns);
}

TEST_F(SessionDocsTest, ExplainsEveryKeyOfTheStatus) {
  const nlohmann::json status = capture_.status();
  const std::string section = docs_.substr(docs_.find("## `status --json`"));
  for (const nlohmann::json& keys : {status, status["lines"][0], status["times"]}) {
    for (const auto& [key, value] : keys.items()) {
      EXPECT_THAT(section, ContainsRegex("`" + key + "(\\[\\])?`"));
    }
  }
}

class MergeSessionsTest : public ::testing::Test {
 protected:
  // Captures lines of the test plan, or of `plan`, in a session; `hour` orders the sessions.
  void capture(const std::string& name, const std::vector<std::string>& lines, int hour,
               int stations = 1000, const CapturePlan& plan = test_plan(true)) {
    TestCapture rig{.directory = root_ / name};
    rig.plan = select_lines(plan, rig.config.camera, lines);
    rig.clock.sleep(std::chrono::hours(hour));
    rig.off_mm = 0.01 * hour;
    const auto session = rig.open();
    session->record_event("run-started", "the rig of " + name);
    rig.capture_missing(session.get(), stations);
  }
  // Of these sessions to "hall".
  std::string merge(const std::vector<std::string>& names, MergeOptions options = {}) {
    for (const std::string& name : names) options.sessions.push_back(root_ / name);
    if (options.out.empty()) options.out = root_ / "hall";
    return merge_sessions(options, &clock_);
  }
  std::string refusal(const std::vector<std::string>& names) {
    const std::string message = error_of([&] { merge(names); });
    EXPECT_FALSE(fs::exists(root_ / "hall"));
    return message;
  }
  std::string events() {
    SessionReader session(root_ / "hall");
    std::string text;
    SqliteStatement row =
        session.query("SELECT kind || ' ' || text FROM event ORDER BY id", "event");
    while (row.step()) text += row.text(0) + "\n";
    return text;
  }

  TestDirectory root_;
  ManualClock clock_{};
};

TEST_F(MergeSessionsTest, SessionsOfSomeLinesBecomeTheSessionOfThePlan) {
  capture("monday", {"x0", "z1"}, 1);
  capture("tuesday", {"x1", "z0", "v0"}, 2);
  EXPECT_THAT(merge({"tuesday", "monday"}), HasSubstr("hall: 15 frames and 5 lines of 2 sessions"));
  SessionReader merged(root_ / "hall");
  EXPECT_TRUE(verify_session(&merged).is_whole());
  std::vector<std::string> stations;
  const SessionContents contents = merged.contents();
  for (const SessionStation& station : contents.stations) {
    EXPECT_TRUE(station.shot) << station.name;
    stations.push_back(station.name);
  }
  EXPECT_EQ(stations.front(), "x0_000");
  EXPECT_EQ(stations.back(), "v0_002");
  // As one run would have left it: complete for the same configuration, and in the order of time.
  TestCapture rig{.directory = root_ / "hall", .plan = test_plan(true)};
  rig.clock.sleep(std::chrono::hours(10));
  EXPECT_EQ(rig.open()->exposure(), "");
  SqliteStatement row = merged.query(
      "SELECT count(*), sum(begun_utc_us < (SELECT begun_utc_us FROM attempt AS before WHERE "
      "before.id = attempt.id - 1)), min(measured_mm - commanded_mm), max(measured_mm - "
      "commanded_mm) FROM attempt",
      "attempts");
  ASSERT_TRUE(row.step());
  EXPECT_EQ(row.integer(0, 0, 100), 15);
  EXPECT_EQ(row.integer(1, 0, 100), 0);
  EXPECT_NEAR(row.real(2, 0.0, 1.0), 0.01, 1e-9);
  EXPECT_NEAR(row.real(3, 0.0, 1.0), 0.02, 1e-9);
  EXPECT_THAT(events(),
              AllOf(HasSubstr("run-started monday: the rig of monday\n"
                              "run-started tuesday: the rig of tuesday\n"),
                    HasSubstr("merged x0: 3 stations of " + (root_ / "monday").string())));
  EXPECT_EQ(fs::hard_link_count(root_ / "hall" / "frames" / "x0_000.jpg"), 2u);
}

TEST_F(MergeSessionsTest, ALineCapturedAgainReplacesTheOlderOneIfAsked) {
  capture("whole", {}, 1);
  capture("again", {"z0"}, 2);
  EXPECT_THAT(refusal({"again", "whole"}),
              AllOf(HasSubstr("line z0 is captured in " + (root_ / "whole").string()),
                    HasSubstr("later, in " + (root_ / "again").string()), HasSubstr("--replace")));
  EXPECT_THAT(merge({"again", "whole"}, {.replace = true}),
              HasSubstr("z0 of again replaces that of whole"));
  const auto is_of = [&](const std::string& frame, const std::string& session) {
    return fs::equivalent(root_ / "hall" / "frames" / frame, root_ / session / "frames" / frame);
  };
  EXPECT_TRUE(is_of("z0_001.jpg", "again"));
  EXPECT_TRUE(is_of("z1_001.jpg", "whole"));
  EXPECT_THAT(events(), HasSubstr("in place of that of " + (root_ / "whole").string()));
}

TEST_F(MergeSessionsTest, MissingAndUnfinishedLinesAreNamed) {
  capture("monday", {"x0", "z0"}, 1, 4);  // one station of z0
  capture("tuesday", {"z1"}, 2);
  EXPECT_THAT(refusal({"monday", "tuesday"}),
              AllOf(HasSubstr("2 lines of the plan: x1, v0"),
                    HasSubstr("not finished: z0 (1 of 3)"), HasSubstr("--partial")));
  EXPECT_THAT(merge({"monday", "tuesday"}, {.partial = true}), HasSubstr("missing: x1, v0"));
  // What is missing is merged into it later.
  capture("wednesday", {"x1", "v0", "z0"}, 3);
  EXPECT_THAT(merge({"hall", "wednesday"}, {.out = root_ / "complete", .replace = true}),
              HasSubstr("15 frames and 5 lines"));
}

TEST_F(MergeSessionsTest, OtherPlansCamerasAndPlacesAreRefused) {
  capture("monday", {"x0"}, 1);
  CapturePlan other = test_plan(true);
  other.lines[1].stations[0].position_m.x_m += 0.01;
  capture("other", {"x1"}, 2, 1000, other);
  EXPECT_THAT(refusal({"monday", "other"}), HasSubstr("different plans"));
  TestCapture rig{.directory = root_ / "card"};
  rig.config.camera.kind = CameraKind::kGpio;
  rig.plan = select_lines(test_plan(true), rig.config.camera, {"x1"});
  rig.open();
  EXPECT_THAT(refusal({"monday", "card"}), HasSubstr("the camera is osc and gpio"));
  EXPECT_THAT(refusal({"monday", "monday"}), HasSubstr("given twice"));
  EXPECT_THAT(error_of([&] { merge({"monday"}, {.out = root_ / "monday"}); }), HasSubstr("exists"));
}

TEST_F(MergeSessionsTest, AStoppedMergeGoesOnAndForeignFilesStay) {
  capture("monday", {}, 1);
  const fs::path partial = root_ / "hall.partial";
  fs::create_directories(partial / "frames");
  write_file_atomically(partial / "frames" / "x0_000.jpg", "half of another merge");
  write_file_atomically(partial / "frames" / "y9_000.jpg", "left over");
  write_file_atomically(partial / "session.db", "torn");
  write_file_atomically(partial / "notes.txt", "mine");
  EXPECT_THAT(refusal({"monday"}), HasSubstr("notes.txt"));
  fs::remove(partial / "notes.txt");
  merge({"monday"});
  SessionReader merged(root_ / "hall");
  EXPECT_TRUE(verify_session(&merged).is_whole());
  EXPECT_FALSE(fs::exists(root_ / "hall" / "frames" / "y9_000.jpg"));
  EXPECT_FALSE(fs::exists(partial));
}

}  // namespace
}  // namespace raywalk::capture
