#include "capture/session/session_status.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "capture/session/session_database.h"
#include "capture/session/test_session.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

class SessionStatusTest : public testing::Test {
 protected:
  nlohmann::json status() {
    SessionReader reader(capture_.directory);
    return session_status(&reader);
  }

  TestDirectory directory_;
  TestCapture capture_{.directory = directory_ / "session", .plan = test_plan(true)};
};

TEST_F(SessionStatusTest, OfAnEmptySessionHasNoTimes) {
  capture_.open();
  const nlohmann::json empty = status();
  EXPECT_EQ(empty["stations"], 15);
  EXPECT_EQ(empty["captured"], 0);
  EXPECT_TRUE(empty["time_left_s"].is_null());
  EXPECT_THAT(empty["next_step"].get<std::string>(),
              AllOf(HasSubstr("run CONFIG"), EndsWith("x0_000")));
  EXPECT_TRUE(empty["times"]["own_ms"].is_null());
}

TEST_F(SessionStatusTest, CountsStationsByLine) {
  capture_.capture_missing(capture_.open().get(), 4);
  const nlohmann::json half = status();
  ASSERT_EQ(half["lines"].size(), 5U);
  EXPECT_EQ(half["lines"][0]["captured"], 3);
  EXPECT_EQ(half["lines"][1]["captured"], 1);
  EXPECT_EQ(half["lines"][1]["stations"], 3);
  EXPECT_TRUE(half["lines"][4]["validation"].get<bool>());
  EXPECT_THAT(half["next_step"].get<std::string>(), EndsWith("x1_001"));
  EXPECT_THAT(status_text(half), AllOf(HasSubstr("4 of 15 stations captured"),
                                       HasSubstr("1 of 3 captured"), HasSubstr("(validation)")));
}

TEST_F(SessionStatusTest, EstimatesTheTimeLeftWithoutBreaks) {
  const std::unique_ptr<Session> session = capture_.open();
  capture_.capture_missing(session.get(), 4);
  capture_.clock.sleep(std::chrono::hours(8));
  capture_.capture_missing(session.get(), 4);
  EXPECT_NEAR(status()["time_left_s"].get<double>(), 2.5 * (15 - 8), 1e-6);
}

TEST_F(SessionStatusTest, ReportsMediansAndTheProgramsOwnTime) {
  const std::unique_ptr<Session> session = capture_.open();
  const std::vector<CaptureStation>&first = capture_.plan.lines[0].stations,
        second = capture_.plan.lines[1].stations;
  const std::vector<const CaptureStation*> stations = {&first[0], &first[1], &first[2], &second[0],
                                                       &second[1]};
  std::size_t number = 0;
  for (const double own_ms : {5.0, 7.0, 6.0, 100.0, 4.0}) {
    const CaptureStation& station = *stations.at(number++);
    const AttemptId attempt = session->begin_attempt(station.name, station.rail_mm);
    const StoredFrame frame = session->store_frame(attempt, 0, test_picture(station.name));
    session->complete_attempt(attempt, settled_at(station.rail_mm, station.rail_mm),
                              capture_.shoot(station.name), std::span(&frame, 1), own_ms);
  }
  const nlohmann::json times = status()["times"];
  EXPECT_EQ(times["own_ms"], 6.0);
  EXPECT_EQ(times["own_p95_ms"], 100.0);
  EXPECT_EQ(times["moving_ms"], 1200.0);
  EXPECT_EQ(times["settling_ms"], 300.0);
  EXPECT_EQ(times["exposing_ms"], 800.0);
  EXPECT_EQ(times["transfer_ms"], 150.0);
  EXPECT_THAT(status_text(status()), HasSubstr("the program itself 6.0 ms (95 % within 100.0 ms)"));
}

TEST_F(SessionStatusTest, CountsFaultsByKind) {
  const std::unique_ptr<Session> session = capture_.open();
  for (const std::string fault : {"stall", "busy", "stall"}) {
    session->fail_attempt(session->begin_attempt("x0_000", 50.0), fault, "what happened");
  }
  const nlohmann::json after = status();
  EXPECT_EQ(after["faults"]["stall"], 2);
  EXPECT_EQ(after["lines"][0]["attempts"], 3);
  EXPECT_EQ(after["captured"], 0);
  EXPECT_THAT(status_text(after), AllOf(HasSubstr("failed attempts: busy 1, stall 2"),
                                        HasSubstr("3 further attempts")));
}

TEST_F(SessionStatusTest, ShowsTheLastEventsOldestFirst) {
  const std::unique_ptr<Session> session = capture_.open();
  for (int i = 0; i < 8; ++i) session->record_event("line-placed", fmt::format("line {}", i));
  const std::string text = status_text(status());
  EXPECT_THAT(text, Not(HasSubstr("line 2")));
  EXPECT_LT(text.find("line 3"), text.find("line 7"));
  EXPECT_THAT(text, HasSubstr("2026-01-01 00:00:00 UTC  line-placed: line 7"));
}

TEST_F(SessionStatusTest, NamesEachStepForACameraThatKeepsItsPictures) {
  capture_.config.camera.kind = CameraKind::kGpio;
  capture_.capture_missing(capture_.open().get());
  EXPECT_EQ(status()["exposed"], 15);
  EXPECT_THAT(status()["next_step"].get<std::string>(), HasSubstr("import"));
  EXPECT_THAT(status_text(status()), HasSubstr("15 on the camera's card"));
}

TEST_F(SessionStatusTest, NamesEachStepOfAFilm) {
  capture_.config.run.mode = CaptureMode::kVideo;
  const std::unique_ptr<Session> session = capture_.open();
  const JournalSample sample{capture_.clock.wall_now(), 50.0};
  session->record_journal("x0", std::span(&sample, 1));
  EXPECT_THAT(status()["next_step"].get<std::string>(), EndsWith("films line x1"));
  EXPECT_TRUE(status()["lines"][0]["filmed"].get<bool>());
  for (const std::string line : {"x1", "z0", "z1", "v0"}) {
    session->record_journal(line, std::span(&sample, 1));
  }
  EXPECT_THAT(status()["next_step"].get<std::string>(), HasSubstr("--video"));
}

TEST_F(SessionStatusTest, EndsWithTheExport) {
  capture_.capture_missing(capture_.open().get());
  EXPECT_EQ(status()["next_step"].get<std::string>(),
            "raywalk-capture export " + capture_.directory.string());
  EXPECT_EQ(status()["time_left_s"], 0.0);
  const nlohmann::json json = status();
  EXPECT_EQ(json["captured"], 15);
  EXPECT_EQ(json["lines"][4]["id"], "v0");
  EXPECT_EQ(json["times"]["own_ms"], 6.5);
}

}  // namespace
}  // namespace raywalk::capture
