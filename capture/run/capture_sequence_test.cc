#include "capture/run/capture_sequence.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <httplib.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "capture/import/test_pictures.h"
#include "capture/run/fake_camera.h"
#include "capture/run/place_rail.h"
#include "capture/run/run_session.h"
#include "capture/run/video_lines.h"
#include "capture/session/test_session.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "simulator/rig/test_slider.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// The attempt that captured a station, and the camera's shot at it; both from 1.
struct Capture {
  std::string station;
  int attempt = 1;
  int shot = 1;
};

// Two lines of three stations at 50, 300 and 550 mm with the simulated drive and a fake camera.
class CaptureSequenceTest : public SessionCase {
 protected:
  CaptureSequenceTest() {
    capture_.plan.lines.push_back(test_line("z0", LineAxis::kZ, 0.5, -0.25, 0.25, 3));
    rules_.approach_mm = 10.0;
    use_slider({});
    camera_.on_shot = [this] { shot_at_mm_.push_back(slider_->true_position_mm()); };
  }

  void use_slider(const TestSlider::Setup& setup) { slider_.emplace(setup, clock()); }
  ManualClock* clock() { return &capture_.clock; }

  // One run of the program, from opening the session to its end.
  void run() {
    const auto session = capture_.open();
    Carriage carriage(slider_->driver(), clock(), limits_, motion_);
    CaptureSequence({&carriage, &camera_, session.get(), place_, clock()}, rules_)
        .run(capture_.plan);
  }
  void record() {
    capture_.config.run.mode = CaptureMode::kVideo;
    const auto session = capture_.open();
    Carriage carriage(slider_->driver(), clock(), limits_, motion_);
    record_lines(capture_.plan, {&carriage, &camera_, session.get(), place_, clock()},
                 {.profile = {50.0, 200.0}, .approach_mm = 5.0, .still_ms = 1000.0});
  }
  std::string paused_message() {
    return error_of([this] { run(); });
  }
  // That the session holds exactly the pictures of these shots, in this order: each frame under its
  // station, attempt and exposure, taken and located there, with the size and checksum of its file;
  // and no other file.
  void expect_frames(const std::vector<Capture>& captures) {
    std::vector<std::string> expected;
    for (const Capture& capture : captures) {
      for (int exposure = 0; exposure < camera_.exposures; ++exposure) {
        expected.push_back(frame_text(capture.station, capture.attempt, exposure,
                                      FakeCamera::picture_text(capture.shot, exposure)));
      }
      EXPECT_NEAR(shot_at_mm_.at(static_cast<std::size_t>(capture.shot) - 1),
                  planned(capture.station).rail_mm, 0.1)
          << capture.station;
    }
    const SessionContents held = contents();
    std::vector<std::string> stored;
    for (const SessionFrame& frame : held.frames) {
      const SessionStation& station = held.station_of(frame);
      const std::string bytes = read_file(capture_.directory / frame.file);
      stored.push_back(frame_text(station.name, station.shot->number, frame.exposure, bytes));
      EXPECT_EQ(frame.bytes, static_cast<std::int64_t>(bytes.size())) << frame.file;
      EXPECT_EQ(frame.sha256, sha256_hex(std::as_bytes(std::span(bytes)))) << frame.file;
      EXPECT_NEAR(frame.position_m.x_m, planned(station.name).position_m.x_m, 1e-4) << frame.file;
      EXPECT_NEAR(frame.position_m.z_m, planned(station.name).position_m.z_m, 1e-4) << frame.file;
    }
    EXPECT_EQ(stored, expected);
    const SessionVerification verification = capture_.verify();
    EXPECT_THAT(verification.faults, IsEmpty());
    EXPECT_THAT(verification.leftover, IsEmpty());
  }
  // The same of all stations, by their first attempts but where others are given.
  void expect_all(const std::map<std::string, int>& attempts = {}) {
    std::vector<Capture> captures;
    int shot = 0;
    for (const CaptureLine& line : capture_.plan.lines) {
      for (const CaptureStation& station : line.stations) {
        const int attempt = attempts.contains(station.name) ? attempts.at(station.name) : 1;
        captures.push_back({station.name, attempt, shot += attempt});
      }
    }
    expect_frames(captures);
  }
  // Every attempt that failed, in order: "x0_001 2: bad-picture".
  std::vector<std::string> failures() {
    SessionReader reader(capture_.directory);
    SqliteStatement row = reader.query(
        "SELECT station.name || ' ' || attempt.number || ': ' || fault FROM attempt "
        "JOIN station ON station.id = station_id WHERE outcome = 'failed' ORDER BY attempt.id",
        "an attempt");
    std::vector<std::string> failures;
    while (row.step()) failures.push_back(row.text(0));
    return failures;
  }

  static std::string frame_text(const std::string& station, int attempt, int exposure,
                                const std::string& bytes) {
    return fmt::format("{} attempt {} exposure {}: {}", station, attempt, exposure, bytes);
  }
  // x0_001 is the second station of its line.
  const CaptureStation& planned(const std::string& name) const {
    const CaptureLine& line = capture_.plan.lines.at(name.starts_with("x0") ? 0 : 1);
    return *std::ranges::find(line.stations, name, &CaptureStation::name);
  }

  SoftLimits limits_{45.0, 600.0};
  MotionRules motion_;
  CaptureRules rules_;
  std::optional<TestSlider> slider_;
  FakeCamera camera_{&capture_.clock};
  std::vector<double> shot_at_mm_;   // where the carriage stood at each shot
  std::vector<std::string> placed_;  // lines
  PlaceRail place_ = [this](const CaptureLine& line, int, int) { placed_.push_back(line.id); };
};

TEST_F(CaptureSequenceTest, CapturesEveryStationOnceLineByLineAndThenNothing) {
  run();
  EXPECT_THAT(placed_, ElementsAre("x0", "z0"));
  EXPECT_THAT(failures(), IsEmpty());
  const int moves = slider_->moves_commanded();
  run();
  EXPECT_EQ(slider_->moves_commanded(), moves);
  EXPECT_EQ(camera_.shots(), 6);
  expect_all();
}

TEST_F(CaptureSequenceTest, ApproachesEveryStationFromBelowWithinTheLimits) {
  use_slider({.backlash_mm = 0.5});
  run();
  const SessionContents held = contents();
  for (const SessionStation& station : held.stations) {
    EXPECT_NEAR(station.shot->measured_mm, station.planned_mm, 0.1);
  }
  EXPECT_GE(slider_->lowest_mm(), 0.0);
  EXPECT_NEAR(slider_->true_position_mm(), 549.5, 0.1);  // on the way up the play is ahead
}

TEST_F(CaptureSequenceTest, ABadPictureOrOneOfAnotherSizeIsNotStoredButShotAgain) {
  camera_.faults = {{2, FaultKind::kBadPicture}, {3, FaultKind::kMissingPicture}};
  camera_.odd_sizes = {{5, {128, 64}}};
  run();
  EXPECT_EQ(camera_.shots(), 9);
  expect_all({{"x0_001", 3}, {"x0_002", 2}});
  EXPECT_THAT(failures(), ElementsAre("x0_001 1: bad-picture", "x0_001 2: missing-picture",
                                      "x0_002 1: bad-picture"));
  EXPECT_EQ(count("frame WHERE width_px = 64 AND height_px = 32"), 6);
}

TEST_F(CaptureSequenceTest, PausesAfterTheAllowedShotsAndResumesThere) {
  camera_.faults = {
      {2, FaultKind::kBadPicture}, {3, FaultKind::kBadPicture}, {4, FaultKind::kBadPicture}};
  EXPECT_THAT(paused_message(),
              AllOf(HasSubstr("station x0_001"), HasSubstr("the fake camera fails; see the test"),
                    HasSubstr("1 of 6 stations captured"), HasSubstr("same command")));
  EXPECT_FALSE(slider_->is_moving());
  expect_frames({{"x0_000", 1, 1}});
  run();
  EXPECT_EQ(camera_.shots(), 4 + 5);
  expect_all({{"x0_001", 4}});
}

TEST_F(CaptureSequenceTest, ACameraThatStaysBusyPausesAtOnce) {
  camera_.faults = {{1, FaultKind::kBusy}};
  EXPECT_THAT(paused_message(), HasSubstr("station x0_000"));
  EXPECT_EQ(camera_.shots(), 1);
  EXPECT_THAT(failures(), ElementsAre("x0_000 1: busy"));
  expect_frames({});
}

TEST_F(CaptureSequenceTest, ThePictureOfAnotherKindThanTheFramesPausesAtTheFirstOfALine) {
  write_test_circles(directory_ / "circles.jpg");
  camera_.files = {{2, read_file(directory_ / "circles.jpg")},
                   {4, read_file(directory_ / "circles.jpg")}};
  EXPECT_THAT(paused_message(),
              AllOf(HasSubstr("station z0_000: the picture shows two fisheye circles"),
                    HasSubstr("camera.frames is panorama"), HasSubstr("3 of 6")));
  EXPECT_EQ(camera_.shots(), 4);  // not shot again
  camera_.files.clear();
  run();  // once the camera is set to stitch
  EXPECT_EQ(capture_.status()["captured"], 6);
}

TEST_F(CaptureSequenceTest, AnIncompleteBracketIsNotStoredButShotAgain) {
  capture_.config.camera.exposure.bracket_ev = {-2.0, 0.0, 2.0};
  camera_.exposures = 3;
  rules_.exposures = 3;
  camera_.fewer_pictures = {{1, 2}, {2, 0}};
  run();
  EXPECT_EQ(camera_.shots(), 8);
  expect_all({{"x0_000", 3}});
  EXPECT_EQ(capture_.status()["faults"], (nlohmann::json{{"missing-picture", 2}}));
}

TEST_F(CaptureSequenceTest, PicturesThatStayOnTheCardLeaveTheStationExposed) {
  capture_.config.camera.kind = CameraKind::kGpio;
  camera_.keeps = true;
  run();
  EXPECT_EQ(camera_.shots(), 6);
  expect_frames({});
  const SessionContents held = contents();
  for (const SessionStation& station : held.stations) {
    ASSERT_TRUE(station.shot && station.shot->on_card) << station.name;
    EXPECT_TRUE(station.shot->triggered_utc_us && station.shot->exposed_utc_us) << station.name;
    EXPECT_NEAR(station.shot->measured_mm, station.planned_mm, 0.1) << station.name;
  }
}

TEST_F(CaptureSequenceTest, ASliderFaultPausesAtItsStationAndIsNotRetried) {
  slider_->faults.add({.kind = RigFault::kStall, .after_ms = 4000.0});
  EXPECT_THAT(paused_message(), AllOf(HasSubstr("station x0_001"), HasSubstr("1 of 6")));
  EXPECT_THAT(failures(), ElementsAre("x0_001 1: stall"));
  EXPECT_EQ(camera_.shots(), 1);
  expect_frames({{"x0_000", 1, 1}});
}

TEST_F(CaptureSequenceTest, AFullDiskPausesBeforeTheSliderMoves) {
  rules_.least_free_bytes = 1e18;
  EXPECT_THAT(paused_message(), AllOf(HasSubstr("station x0_000"), HasSubstr("free some")));
  EXPECT_EQ(camera_.shots(), 0);
  EXPECT_EQ(capture_.status()["lines"][0]["attempts"], 0);
}

TEST_F(CaptureSequenceTest, OwnTimeExcludesWhatTheDevicesTake) {
  run();
  // Simulated time passes only while the fakes work.
  EXPECT_NEAR(capture_.status()["times"]["own_ms"].get<double>(), 0.0, motion_.poll_ms + 1.0);
  EXPECT_NEAR(capture_.status()["times"]["exposing_ms"].get<double>(), 400.0, 1e-6);
}

TEST_F(CaptureSequenceTest, RecordsEachLineWithAJournalOfThePass) {
  record();
  EXPECT_EQ(camera_.videos(), 2);
  EXPECT_FALSE(camera_.is_recording());
  const auto journal = SessionReader(capture_.directory).journal("x0");
  ASSERT_GT(journal.size(), 100u);
  EXPECT_NEAR(journal.front().position_mm, 45.0, 1.0);
  EXPECT_NEAR(journal.back().position_mm, 555.0, 0.5);
  record();
  EXPECT_EQ(camera_.videos(), 2);  // nothing is left to record
}

TEST_F(CaptureSequenceTest, AStallWhileRecordingEndsTheVideoAndKeepsNoJournal) {
  slider_->faults.add({.kind = RigFault::kStall, .after_ms = 6000.0});
  EXPECT_THROW(record(), Paused);
  EXPECT_EQ(camera_.videos(), 1);
  EXPECT_FALSE(camera_.is_recording());
  EXPECT_FALSE(capture_.open()->has_journal("x0"));
}

TEST(RunSession, OfASessionThatIsRecordedNeedsNoDevice) {
  const TestDirectory directory;
  CaptureConfig config;
  config.grid.spacing_mm = 50.0;
  config.slider.high_limit_mm = 2000.0;
  config.file = directory / "capture.yaml";
  write_file_atomically(config.file, "");
  config.run.mode = CaptureMode::kVideo;
  TestCapture recorded{
      .directory = directory / "hall", .plan = plan_capture(config), .config = config};
  const JournalSample sample{recorded.clock.wall_now(), 50.0};
  for (const CaptureLine& line : recorded.plan.lines) {
    recorded.open()->record_journal(line.id, {&sample, 1});
  }
  EXPECT_THAT(run_session(config, {.session = directory / "hall"}),
              AllOf(HasSubstr("all 4 lines are recorded"), HasSubstr("--video")));
}

// --- Placing the rail ----------------------------------------------------------------------------

const CaptureLine kLine = test_line("z1", LineAxis::kZ, 0.5, -0.75, 0.25, 7);

// What a rig is asked when the line is placed, and the error that its answer with a status is.
struct Placing {
  std::string request{};
  std::string error{};
};
Placing placing_at_rig(int status) {
  Placing placing;
  httplib::Server server;
  server.Post("/rig/place", [&](const httplib::Request& request, httplib::Response& reply) {
    placing.request = request.body;
    reply.status = status;
    reply.set_content("no such line", "text/plain");
  });
  const int port = server.bind_to_any_port("127.0.0.1");
  const std::jthread thread([&] { server.listen_after_bind(); });
  while (!server.is_running()) std::this_thread::yield();
  RunConfig config;
  config.place_url = fmt::format("http://127.0.0.1:{}/rig/place", port);
  placing.error = error_of([&] { place_rail(config, false, kLine, 1, 1); });
  server.stop();
  return placing;
}

TEST(PlacementText, SaysWhereBothEndsOfTheLineBelong) {
  EXPECT_THAT(
      placement_text(kLine, 4, 5),
      AllOf(HasSubstr("z1 (4 of 5)"), HasSubstr("50.0 mm belongs at x = +0.500 m, z = -0.750 m"),
            HasSubstr("towards +z"), HasSubstr("z = +0.750 m at 1550.0 mm")));
}

TEST(PlaceRail, SendsTheLineToARigThatPlacesItselfAndShowsItsRefusal) {
  const Placing placing = placing_at_rig(200);
  EXPECT_EQ(placing.error, "no error");
  EXPECT_EQ(nlohmann::json::parse(placing.request), nlohmann::json::parse(R"(
      {"line": "z1", "placement": 1, "start_m": [0.5, -0.75], "end_m": [0.5, 0.75]})"));
  EXPECT_THAT(placing_at_rig(404).error,
              AllOf(HasSubstr("z1"), HasSubstr("404"), HasSubstr("no such line")));
}

TEST(PlaceRail, ARigThatIsOffIsAnError) {
  RunConfig config;
  config.place_url = "http://127.0.0.1:1/rig/place";
  config.place_timeout_ms = 500.0;
  const std::string error = error_of([&] { place_rail(config, false, kLine, 1, 1); });
  EXPECT_THAT(error, AllOf(HasSubstr("127.0.0.1:1"), HasSubstr("run.place_timeout_ms")));
}

TEST(PlaceRail, YesDoesNotAskTheOperator) { place_rail({}, true, kLine, 1, 1); }

}  // namespace
}  // namespace raywalk::capture
