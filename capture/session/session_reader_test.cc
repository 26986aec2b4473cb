#include <gmock/gmock.h>

#include "capture/session/session_database.h"
#include "capture/session/test_session.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using testing::HasSubstr;

class SessionReaderTest : public testing::Test {
 protected:
  TestDirectory directory_;
  TestCapture capture_{.directory = directory_ / "session", .plan = test_plan(true)};
};

TEST_F(SessionReaderTest, SeesWhatARunCommitsWhileItRuns) {
  const std::unique_ptr<Session> session = capture_.open();
  SessionReader reader(capture_.directory);
  EXPECT_TRUE(reader.contents().frames.empty());
  capture_.capture_missing(session.get(), 2);
  EXPECT_EQ(reader.contents().frames.size(), 2U);
  EXPECT_TRUE(reader.contents().stations[1].shot);
  EXPECT_FALSE(reader.contents().stations[2].shot);
}

TEST_F(SessionReaderTest, ReadsThePlanAsWritten) {
  capture_.open();
  const CapturePlan plan = SessionReader(capture_.directory).plan();
  const CapturePlan& expected = capture_.plan;
  ASSERT_EQ(plan.lines.size(), expected.lines.size());
  for (std::size_t i = 0; i < plan.lines.size(); ++i) {
    EXPECT_EQ(plan.lines[i].id, expected.lines[i].id);
    EXPECT_EQ(plan.lines[i].axis, expected.lines[i].axis);
    EXPECT_EQ(plan.lines[i].across_m, expected.lines[i].across_m);
    EXPECT_EQ(plan.lines[i].validation, expected.lines[i].validation);
    ASSERT_EQ(plan.lines[i].stations.size(), expected.lines[i].stations.size());
    for (std::size_t j = 0; j < plan.lines[i].stations.size(); ++j) {
      const CaptureStation& there = plan.lines[i].stations[j];
      const CaptureStation& here = expected.lines[i].stations[j];
      EXPECT_EQ(there.name, here.name);
      EXPECT_EQ(there.position_m.x_m, here.position_m.x_m);
      EXPECT_EQ(there.position_m.z_m, here.position_m.z_m);
      EXPECT_EQ(there.rail_mm, here.rail_mm);
    }
  }
}

// The position along the line is that of the feedback, the position across it as planned.
TEST_F(SessionReaderTest, PlacesFramesByTheMeasuredPositionOnTheRail) {
  capture_.off_mm = -1.5;
  capture_.capture_missing(capture_.open().get());
  SessionReader reader(capture_.directory);
  const SessionContents contents = reader.contents();
  std::size_t i = 0;
  for (const CaptureLine& line : capture_.plan.lines) {
    for (const CaptureStation& station : line.stations) {
      const SessionFrame& frame = contents.frames.at(i++);
      const SessionStation& captured = contents.station_of(frame);
      const double dx_m = line.axis == LineAxis::kX ? -0.0015 : 0.0;
      EXPECT_EQ(captured.name, station.name);
      EXPECT_EQ(contents.line_of(captured).validation, line.id == "v0");
      EXPECT_NEAR(frame.position_m.x_m, station.position_m.x_m + dx_m, 1e-12);
      EXPECT_NEAR(frame.position_m.z_m, station.position_m.z_m - 0.0015 - dx_m, 1e-12);
    }
  }
}

TEST_F(SessionReaderTest, ReadsTheFactsOfTheSession) {
  capture_.config.camera.frames = FrameKind::kDualFisheye;
  capture_.config.camera.exposure.bracket_ev = {0.0, 2.0, -2.0};
  capture_.open();
  const SessionFacts facts = SessionReader(capture_.directory).facts();
  EXPECT_EQ(facts.created, ManualClock().wall_now());
  EXPECT_EQ(facts.mode, CaptureMode::kStations);
  EXPECT_EQ(facts.camera, CameraKind::kOsc);
  EXPECT_EQ(facts.frames, FrameKind::kDualFisheye);
  EXPECT_EQ(facts.bracket_ev, (std::vector{0.0, 2.0, -2.0}));
  EXPECT_EQ(facts.config_text, "camera:\n  kind: osc\n");
}

TEST_F(SessionReaderTest, AnUnknownModeCameraOrFrameKindIsAnError) {
  capture_.open();
  for (const std::string column : {"mode", "camera", "frames"}) {
    const std::string known =
        SessionReader(capture_.directory).database().text("SELECT " + column + " FROM session");
    const auto write = [&](const std::string& word) {
      open_session_to_write(capture_.directory)
          .execute("UPDATE session SET " + column + " = '" + word + "'");
    };
    write("other");
    EXPECT_THAT(error_of([&] { SessionReader(capture_.directory).facts(); }), HasSubstr("'other'"))
        << column;
    write(known);
    EXPECT_EQ(error_of([&] { SessionReader(capture_.directory).facts(); }), "") << column;
  }
}

TEST_F(SessionReaderTest, RefusesFramesOutsideTheSession) {
  capture_.capture_missing(capture_.open().get(), 1);
  for (const std::string trap : {"/etc/passwd", "frames/../../secret"}) {
    open_session_to_write(capture_.directory).execute("UPDATE frame SET file = '" + trap + "'");
    SessionReader reader(capture_.directory);
    EXPECT_THAT(error_of([&] { reader.contents(); }), HasSubstr("not in its directory")) << trap;
  }
}

}  // namespace
}  // namespace raywalk::capture
