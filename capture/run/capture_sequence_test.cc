#include "capture/run/capture_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "capture/run/fake_camera.h"
#include "capture/run/film_lines.h"
#include "capture/session/session_reader.h"
#include "capture/session/session_status.h"
#include "capture/session/session_verify.h"
#include "capture/session/test_session.h"
#include "capture/slider/fake_slider.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class RememberingPlacer final : public RailPlacer {
 public:
  void place(const CaptureLine& line, int /*number*/, int /*count*/) override {
    lines.push_back(line.id);
  }
  std::vector<std::string> lines;
};

// Two lines of three stations at 50, 300 and 550 mm with a fake slider and camera.
class CaptureSequenceTest : public ::testing::Test {
 protected:
  CaptureSequenceTest() {
    capture_.directory = directory_ / "session";
    capture_.plan = CapturePlan{};
    capture_.plan.lines.push_back(test_line("x0", LineAxis::kX, 0.5, -0.25, 0.25, 3));
    capture_.plan.lines.push_back(test_line("z0", LineAxis::kZ, 0.5, -0.25, 0.25, 3));
    rules_.approach_mm = 10.0;
    use_slider("");
  }

  void use_slider(const std::string& yaml) {
    slider_.emplace(parse_fake_slider_config(yaml, "fake.yaml"), clock());
  }
  ManualClock* clock() { return &capture_.clock; }

  // One run of the program, from opening the session to its end.
  void run() {
    const auto session = capture_.open();
    Carriage carriage(&*slider_, clock(), limits_, motion_);
    CaptureSequence({&carriage, &camera_, session.get(), &placer_, clock()}, rules_)
        .run(capture_.plan);
  }
  std::string paused_message() {
    try {
      run();
    } catch (const Paused& paused) {
      return paused.what();
    }
    return "was not paused";
  }
  SessionStatus status() {
    SessionReader reader(capture_.directory);
    return status_of(&reader);
  }
  std::vector<std::string> files() {
    std::vector<std::string> files;
    for (const FrameRecord& frame : SessionReader(capture_.directory).frames()) {
      files.push_back(frame.file);
    }
    return files;
  }

  TestDirectory directory_;
  TestCapture capture_;
  SoftLimits limits_{45.0, 600.0};
  MotionRules motion_;
  CaptureRules rules_;
  std::optional<FakeSlider> slider_;
  FakeCamera camera_{&capture_.clock};
  RememberingPlacer placer_;
};

TEST_F(CaptureSequenceTest, CapturesEveryStationOnceLineByLine) {
  run();
  EXPECT_EQ(status().captured(), 6);
  EXPECT_EQ(camera_.shots(), 6);
  EXPECT_THAT(placer_.lines, ElementsAre("x0", "z0"));
  EXPECT_EQ(files().size(), 6u);
  SessionReader reader(capture_.directory);
  EXPECT_THAT(verify_session(&reader).faults, IsEmpty());
}

TEST_F(CaptureSequenceTest, ApproachesEveryStationFromBelowWithinTheLimits) {
  use_slider("backlash_mm: 0.5");
  run();
  for (const StationRecord& station : SessionReader(capture_.directory).stations()) {
    EXPECT_NEAR(*station.measured_mm, station.planned_mm, 0.1);
  }
  EXPECT_GE(slider_->lowest_mm(), 0.0);
  EXPECT_NEAR(slider_->true_position_mm(), 550.0, 0.1);  // no play on the way up
}

TEST_F(CaptureSequenceTest, AFinishedSessionIsLeftAlone) {
  run();
  const int moves = slider_->moves_commanded();
  run();
  EXPECT_EQ(slider_->moves_commanded(), moves);
  EXPECT_EQ(camera_.shots(), 6);
}

TEST_F(CaptureSequenceTest, ABadPictureIsShotAgain) {
  camera_.faults = {{2, FaultKind::kBadPicture}, {3, FaultKind::kMissingPicture}};
  run();
  EXPECT_EQ(status().captured(), 6);
  EXPECT_EQ(camera_.shots(), 8);
  EXPECT_THAT(status().faults,
              ElementsAre(std::pair<const std::string, int>("bad-picture", 1),
                          std::pair<const std::string, int>("missing-picture", 1)));
}

TEST_F(CaptureSequenceTest, PausesAfterTheShotsAllowedAndGoesOnWhereItStopped) {
  camera_.faults = {
      {2, FaultKind::kBadPicture}, {3, FaultKind::kBadPicture}, {4, FaultKind::kBadPicture}};
  EXPECT_THAT(paused_message(),
              AllOf(HasSubstr("station x0_001"), HasSubstr("the fake camera fails; see the test"),
                    HasSubstr("1 of 6 stations captured"), HasSubstr("same command")));
  EXPECT_FALSE(slider_->is_moving());
  run();
  EXPECT_EQ(status().captured(), 6);
  EXPECT_EQ(camera_.shots(), 4 + 5);
}

TEST_F(CaptureSequenceTest, ACameraThatStaysBusyPausesAtOnce) {
  camera_.faults = {{1, FaultKind::kBusy}};
  EXPECT_THAT(paused_message(), HasSubstr("station x0_000"));
  EXPECT_EQ(camera_.shots(), 1);
}

TEST_F(CaptureSequenceTest, PicturesOfAnotherSizeAreNotMixedIn) {
  camera_.odd_sizes = {{2, {128, 64}}};
  run();
  EXPECT_EQ(camera_.shots(), 7);
  camera_.odd_sizes = {};
}

TEST_F(CaptureSequenceTest, FewerPicturesThanAskedForAreMissing) {
  capture_.config.camera.exposure.bracket_ev = {-2.0, 0.0, 2.0};
  camera_.exposures = 3;
  rules_.exposures = 3;
  camera_.fewer_pictures = {{1, 2}, {2, 0}};
  run();
  EXPECT_EQ(files().size(), 18u);
  EXPECT_EQ(camera_.shots(), 8);
}

TEST_F(CaptureSequenceTest, PicturesThatStayOnTheCardLeaveTheStationExposed) {
  capture_.config.camera.kind = CameraKind::kGpio;
  camera_.keeps = true;
  run();
  EXPECT_EQ(status().exposed(), 6);
  EXPECT_EQ(status().captured(), 0);
}

TEST_F(CaptureSequenceTest, ASliderFaultPausesAtItsStationAndIsNotRetried) {
  use_slider("faults: [{kind: stall, at_mm: 200}]");
  EXPECT_THAT(paused_message(), AllOf(HasSubstr("station x0_001"), HasSubstr("1 of 6")));
  EXPECT_THAT(status().faults, ElementsAre(std::pair<const std::string, int>("stall", 1)));
  EXPECT_EQ(camera_.shots(), 1);
}

TEST_F(CaptureSequenceTest, AFullDiskPausesBeforeTheSliderMoves) {
  rules_.least_free_bytes = 1e18;
  EXPECT_THAT(paused_message(), AllOf(HasSubstr("station x0_000"), HasSubstr("free some")));
  EXPECT_EQ(camera_.shots(), 0);
}

TEST_F(CaptureSequenceTest, AClockThatIsSetBackPauses) {
  rules_.shots = 1;
  camera_.faults = {{3, FaultKind::kBadPicture}};
  paused_message();
  clock()->shift_wall(-std::chrono::hours(2));
  EXPECT_THAT(paused_message(), HasSubstr("clock"));
  EXPECT_EQ(status().captured(), 2);
}

TEST_F(CaptureSequenceTest, TheOwnShareOfAStationIsWhatNeitherDeviceTook) {
  run();
  // Simulated time passes only while the fakes work.
  EXPECT_NEAR(*status().times.own_ms, 0.0, motion_.poll_ms + 1.0);
  EXPECT_NEAR(*status().times.exposing_ms, 400.0, 1e-6);
}

TEST_F(CaptureSequenceTest, FilmsEachLineWithAJournalOfThePass) {
  capture_.config.run.mode = CaptureMode::kVideo;
  const auto film = [&] {
    const auto session = capture_.open();
    Carriage carriage(&*slider_, clock(), limits_, motion_);
    film_lines(capture_.plan, {&carriage, &camera_, session.get(), &placer_, clock()},
               {.profile = {50.0, 200.0}, .approach_mm = 5.0, .still_ms = 1000.0});
  };
  film();
  EXPECT_EQ(camera_.films(), 2);
  EXPECT_FALSE(camera_.is_filming());
  const auto journal = SessionReader(capture_.directory).journal("x0");
  ASSERT_GT(journal.size(), 100u);
  EXPECT_NEAR(journal.front().position_mm, 45.0, 1.0);
  EXPECT_NEAR(journal.back().position_mm, 555.0, 0.5);
  film();
  EXPECT_EQ(camera_.films(), 2);  // nothing is left to film
}

TEST_F(CaptureSequenceTest, AStallWhileFilmingEndsTheFilmAndKeepsNoJournal) {
  capture_.config.run.mode = CaptureMode::kVideo;
  use_slider("faults: [{kind: stall, at_mm: 200}]");
  const auto session = capture_.open();
  Carriage carriage(&*slider_, clock(), limits_, motion_);
  EXPECT_THROW(film_lines(capture_.plan, {&carriage, &camera_, session.get(), &placer_, clock()},
                          {.profile = {50.0, 200.0}}),
               Paused);
  EXPECT_FALSE(camera_.is_filming());
  EXPECT_FALSE(session->has_journal("x0"));
}

}  // namespace
}  // namespace raywalk::capture
