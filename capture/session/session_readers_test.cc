// What status, verify and export say of a session.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "capture/session/session_frames.h"
#include "capture/session/session_status.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/geometry/grid.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

namespace fs = std::filesystem;

// 15 stations: 4 lines of a cell, and one for validation.
class SessionReadersTest : public SessionCase {
 protected:
  SessionReadersTest() : SessionCase(test_plan(true)) {}

  nlohmann::json status() {
    SessionReader reader(capture_.directory);
    return session_status(&reader);
  }
  std::string next_step() { return status()["next_step"]; }
  SessionVerification verify() {
    SessionReader reader(capture_.directory);
    return verify_session(&reader);
  }
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
  std::size_t number = 0;
  for (const double own_ms : {5.0, 7.0, 6.0, 100.0, 4.0}) {
    const CaptureStation& station = capture_.plan.lines.at(number / 3).stations.at(number % 3);
    ++number;
    const AttemptId attempt = session->begin_attempt(station.name, station.rail_mm);
    const StoredFrame frame = session->store_frame(attempt, 0, test_picture(station.name));
    session->complete_attempt(attempt, settled_at(station.rail_mm, station.rail_mm),
                              capture_.shoot(station.name), {&frame, 1}, own_ms);
  }
  EXPECT_EQ(status()["times"], (nlohmann::json{{"moving_ms", 1200.0},
                                               {"settling_ms", 300.0},
                                               {"exposing_ms", 800.0},
                                               {"transfer_ms", 150.0},
                                               {"own_ms", 6.0},
                                               {"own_p95_ms", 100.0}}));
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

TEST_F(SessionReadersTest, StatusNamesEachStepOfAFilm) {
  capture_.config.run.mode = CaptureMode::kVideo;
  const std::unique_ptr<Session> session = capture_.open();
  const JournalSample sample{capture_.clock.wall_now(), 50.0};
  session->record_journal("x0", {&sample, 1});
  EXPECT_THAT(next_step(), EndsWith("films line x1"));
  EXPECT_TRUE(status()["lines"][0]["filmed"].get<bool>());
  for (const std::string line : {"x1", "z0", "z1", "v0"}) {
    session->record_journal(line, {&sample, 1});
  }
  EXPECT_THAT(next_step(), HasSubstr("--video"));
}

TEST_F(SessionReadersTest, VerifyListsFilesOfNoStationWithoutAFault) {
  capture_.capture_missing(capture_.open().get());
  EXPECT_THAT(verify().leftover, IsEmpty());
  std::ofstream(capture_.directory / "frames/x0_001_a2.jpg") << "left";
  const SessionVerification verification = verify();
  EXPECT_TRUE(verification.is_whole());
  EXPECT_EQ(verification.frames, 15);
  EXPECT_EQ(verification.bytes,
            15 * static_cast<std::int64_t>(test_picture("x0_000 0").bytes.size()));
  EXPECT_THAT(verification_text(verification), HasSubstr("frames/x0_001_a2.jpg: belongs to no"));
}

TEST_F(SessionReadersTest, StationsOfLostFramesCanBeGivenUpAndCapturedAgain) {
  capture_.capture_missing(capture_.open().get());
  fs::remove(capture_.directory / "frames/x0_001.jpg");
  std::ofstream(capture_.directory / "frames/x0_002.jpg") << "other";
  EXPECT_THAT(status_text(status()), AllOf(HasSubstr("13 of 15 stations captured, 2 lost"),
                                           HasSubstr("lost: frames/x0_0"), HasSubstr("--give-up")));
  EXPECT_THAT(give_up_lost_stations(verify(), capture_.directory, &capture_.clock),
              HasSubstr("2 stations given up"));
  EXPECT_TRUE(verify().is_whole());
  EXPECT_EQ(verify().frames, 13);
  const std::unique_ptr<Session> session = capture_.open();
  EXPECT_TRUE(session->is_captured("x0_000"));
  EXPECT_FALSE(session->is_captured("x0_001"));
  capture_.capture_missing(session.get());
  EXPECT_TRUE(verify().is_whole());
  EXPECT_EQ(verify().frames, 15);
  EXPECT_THAT(verify().leftover, ElementsAre("frames/x0_002.jpg"));
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
  const auto expect_at = [](const CsvTable& list, std::size_t row, double x_m, double z_m) {
    EXPECT_NEAR(list.number(row, "x"), x_m, 1e-9);
    EXPECT_NEAR(list.number(row, "z"), z_m, 1e-9);
  };
  expect_at(poses, 0, -0.75 + 0.0005, -0.5);
  expect_at(poses, 11, 0.5, 0.75 + 0.0005);
  expect_at(truth, 0, -0.25 + 0.0005, 0.0);
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

}  // namespace
}  // namespace raywalk::capture
