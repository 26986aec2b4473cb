#include "capture/session/session.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <functional>

#include "capture/session/session_database.h"
#include "capture/session/session_frames.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

namespace fs = std::filesystem;

class SessionTest : public SessionCase {};

TEST_F(SessionTest, KeepsEveryNumberOfAStation) {
  capture_.off_mm = 0.25;
  capture_.capture_missing(capture_.open().get(), 1);
  EXPECT_EQ(open_session_to_read(capture_.directory)
                .text("SELECT outcome || ' ' || commanded_mm || ' ' || measured_mm || ' ' || "
                      "moving_ms || ' ' || settling_ms || ' ' || exposing_ms || ' ' || "
                      "transfer_ms || ' ' || own_ms FROM attempt"),
            "captured 50.0 50.25 1200.0 300.0 800.0 150.0 6.5");
  EXPECT_EQ(count("attempt WHERE begun_utc_us = 1767225600000000"), 1);  // 2026-01-01
  for (const std::string time : {"triggered", "exposed", "ended"}) {
    EXPECT_EQ(count("attempt WHERE " + time + "_utc_us = begun_utc_us + 2500000"), 1) << time;
  }
}

TEST_F(SessionTest, DistinguishesFramesOfABracketAndOfTwoLenses) {
  capture_.config.camera.exposure.bracket_ev = {0.0, -2.0};
  const std::unique_ptr<Session> session = capture_.open();
  const AttemptId attempt = session->begin_attempt("x0_000", 50.0);
  std::vector<StoredFrame> frames;
  for (const int exposure : {0, 1}) {
    for (const FrameLens lens : {FrameLens::kFront, FrameLens::kBack}) {
      frames.push_back(session->store_frame(attempt, exposure, test_picture("any"), lens));
    }
  }
  session->complete_attempt(attempt, settled_at(50.0, 50.0), capture_.shoot("x0_000"), frames, 1.0);
  EXPECT_THAT(list_frames(capture_.directory),
              ElementsAre("frames/x0_000_back.jpg", "frames/x0_000_e1_back.jpg",
                          "frames/x0_000_e1_front.jpg", "frames/x0_000_front.jpg"));
  EXPECT_EQ(count("frame WHERE exposure = 1 AND lens = 'back'"), 1);
}

TEST_F(SessionTest, AFailedAttemptIsKeptAndTheStationShotAgain) {
  const std::unique_ptr<Session> session = capture_.open();
  const AttemptId first = session->begin_attempt("x0_000", 50.0);
  session->store_frame(first, 0, test_picture("first"));
  session->fail_attempt(first, "bad-picture", "the second exposure was cut short");
  EXPECT_FALSE(session->is_captured("x0_000"));
  capture_.capture(session.get(), capture_.plan.lines[0].stations[0]);
  EXPECT_TRUE(session->is_captured("x0_000"));
  EXPECT_THAT(list_frames(capture_.directory),
              ElementsAre("frames/x0_000.jpg", "frames/x0_000_a2.jpg"));
  EXPECT_EQ(read_file(capture_.directory / "frames/x0_000.jpg"), test_picture("first").bytes);
  EXPECT_EQ(count("attempt WHERE fault = 'bad-picture' AND outcome = 'failed'"), 1);
}

TEST_F(SessionTest, TheAttemptOfAKilledRunIsMarkedAndItsFilesStay) {
  {
    const std::unique_ptr<Session> killed = capture_.open();
    const AttemptId attempt = killed->begin_attempt("x0_000", 50.0);
    killed->store_frame(attempt, 0, test_picture("killed"));
    std::ofstream(capture_.directory / "frames/.x0_000_e1.0-1.2.partial.jpg") << "half";
  }
  const std::unique_ptr<Session> session = capture_.open();
  EXPECT_EQ(count("attempt WHERE outcome = 'failed' AND fault = 'interrupted'"), 1);
  EXPECT_EQ(count("event WHERE kind = 'tidied-up'"), 1);
  capture_.capture_missing(session.get());
  SessionReader reader(capture_.directory);
  const SessionVerification verification = verify_session(&reader);
  EXPECT_TRUE(verification.is_whole());
  EXPECT_THAT(verification.leftover, ElementsAre("frames/x0_000.jpg"));
  EXPECT_EQ(contents().frames.size(), 3U);
}

TEST_F(SessionTest, AStationIsCapturedOnceAndAnAttemptEndsOnce) {
  const std::unique_ptr<Session> session = capture_.open();
  capture_.capture_missing(session.get(), 1);
  const AttemptId again = session->begin_attempt("x0_000", 50.0);
  const StoredFrame frame = session->store_frame(again, 0, test_picture("again"));
  EXPECT_THROW(session->complete_attempt(again, settled_at(50.0, 50.0), capture_.shoot("x0_000"),
                                         {&frame, 1}, 1.0),
               Error);
  EXPECT_EQ(count("frame"), 1);
  session->fail_attempt(again, "stall", "stood still");
  EXPECT_THROW(session->fail_attempt(again, "stall", "stood still"), std::logic_error);
  EXPECT_THROW(session->begin_attempt("x9_000", 0.0), std::logic_error);
}

TEST_F(SessionTest, PicturesOnTheCardAreAddedLaterAndAgainWhenLost) {
  capture_.config.camera.kind = CameraKind::kGpio;
  capture_.capture_missing(capture_.open().get());
  const SessionStation exposed = contents().stations[1];
  ASSERT_TRUE(exposed.shot && exposed.shot->on_card);
  ASSERT_TRUE(exposed.shot->exposed_utc_us.has_value());
  const AttemptId attempt{exposed.shot->attempt, exposed.name, exposed.shot->number};

  const std::unique_ptr<Session> session = Session::open(capture_.directory, &capture_.clock);
  EXPECT_TRUE(session->is_captured("x0_001"));
  const StoredFrame frame = session->store_frame(attempt, 0, test_picture("card"));
  session->add_pictures(attempt, {&frame, 1});
  EXPECT_FALSE(contents().stations[1].shot->on_card);
  EXPECT_EQ(contents().frames.size(), 1U);
  EXPECT_THROW(session->add_pictures(attempt, {&frame, 1}), std::logic_error);
  session->give_up_frames("x0_001");
  EXPECT_TRUE(contents().stations[1].shot->on_card);
  EXPECT_THAT(contents().frames, IsEmpty());
}

TEST_F(SessionTest, AFrameOfAFilmIsCapturedWhereTheCarriageWas) {
  const std::unique_ptr<Session> session = capture_.open();
  const std::vector<JournalSample> samples = {{capture_.clock.wall_now(), 50.0},
                                              {capture_.clock.wall_now(), 60.0}};
  EXPECT_FALSE(session->has_journal("x0"));
  session->record_journal("x0", samples);
  EXPECT_TRUE(session->has_journal("x0"));
  const AttemptId attempt = session->begin_attempt("x0_000", 50.0);
  const StoredFrame frame = session->store_frame(attempt, 0, test_picture("film"));
  session->complete_from_film(attempt, 51.5, capture_.clock.wall_now(), {&frame, 1});
  const std::vector<JournalSample> journal = SessionReader(capture_.directory).journal("x0");
  ASSERT_EQ(journal.size(), 2U);
  EXPECT_EQ(journal[1].position_mm, 60.0);
  EXPECT_NEAR(contents().frames.at(0).position_m.x_m, -0.25 + 0.0015, 1e-12);
}

TEST_F(SessionTest, ConfigurationExposureAndEventsStay) {
  {
    const std::unique_ptr<Session> session = capture_.open();
    EXPECT_EQ(session->exposure(), "");
    session->set_exposure(R"({"iso": 200})");
    session->record_event("line-placed", "x0");
  }
  EXPECT_EQ(capture_.open()->exposure(), R"({"iso": 200})");
  const SessionFacts facts = SessionReader(capture_.directory).facts();
  EXPECT_EQ(facts.created, capture_.clock.wall_now());
  EXPECT_EQ(facts.config_text, "camera:\n  kind: osc\n");
  EXPECT_EQ(count("event WHERE kind = 'line-placed' AND text = 'x0'"), 1);
}

TEST_F(SessionTest, RefusesAnotherPlanWithTheFirstDifference) {
  capture_.open();
  struct Case {
    std::function<void(CaptureLine* line, CameraConfig* camera)> change;
    std::string message;
  };
  const Case cases[] = {
      {[](auto* line, auto*) { line->stations.pop_back(); },
       "holds another plan: lines/x0/stations/x0_002 is planned there, not planned here"},
      {[](auto* line, auto*) { line->stations[1].rail_mm += 10.0; },
       "lines/x0/stations/x0_001/rail_mm is 300.0 there, 310.0 here"},
      {[](auto* line, auto*) { line->stations[1].rail_mm += 1e-9; }, "no error"},  // of rounding
      {[](auto*, auto* camera) { camera->frames = FrameKind::kDualFisheye; },
       R"(frames is "panorama" there, "dual-fisheye" here)"},
      {[](auto*, auto* camera) {
         camera->exposure.bracket_ev = {0.0, -2.0};
       },
       "bracket_ev is [0.0] there, [0.0,-2.0] here"}};
  for (const Case& each : cases) {
    capture_.plan = short_plan();
    capture_.config = {};
    each.change(&capture_.plan.lines[0], &capture_.config.camera);
    EXPECT_THAT(error_of_opening(), HasSubstr(each.message));
  }
}

TEST_F(SessionTest, RefusesASecondWriter) {
  const std::unique_ptr<Session> first = capture_.open();
  EXPECT_THAT(error_of_opening(),
              AllOf(HasSubstr(capture_.directory.string()), HasSubstr("another raywalk-capture")));
}

TEST_F(SessionTest, RefusesFramesWithoutTheirDatabaseAndTheReverse) {
  capture_.capture_missing(capture_.open().get(), 2);
  const fs::path frames = capture_.directory / "frames";
  fs::rename(frames, capture_.directory / "away");
  EXPECT_THAT(error_of_opening(), AllOf(HasSubstr("frames is missing"), HasSubstr("2 frames")));
  EXPECT_FALSE(fs::exists(frames));
  fs::rename(capture_.directory / "away", frames);
  fs::remove(database());
  EXPECT_THAT(error_of_opening(), AllOf(HasSubstr("holds frames"), HasSubstr("session.db")));
}

TEST_F(SessionTest, DoesNotTakeOverAFolderOfOtherFiles) {
  fs::create_directories(capture_.directory);
  for (const std::string name : {"poses.csv", "IMG_0001.jpg", ".hidden"}) {
    std::ofstream(capture_.directory / name) << "mine";
    EXPECT_THAT(error_of_opening(),
                AllOf(HasSubstr(capture_.directory.string()), HasSubstr(name),
                      HasSubstr("not a session"), HasSubstr("give a new folder")));
    fs::remove(capture_.directory / name);
    EXPECT_TRUE(fs::is_empty(capture_.directory)) << "nothing was written";
  }
  std::ofstream(database()).close();  // of an interrupted creation
  EXPECT_EQ(error_of_opening(), "no error");
  std::ofstream(capture_.directory / "notes.txt") << "of a session: mine as well";
  EXPECT_EQ(error_of_opening(), "no error");
}

TEST_F(SessionTest, RefusesAClockThatWasSetBackButNotByATimeServer) {
  const std::unique_ptr<Session> session = capture_.open();
  capture_.capture_missing(session.get(), 1);
  capture_.clock.shift_wall(std::chrono::milliseconds(-300));
  EXPECT_NO_THROW(session->begin_attempt("x0_001", 300.0));
  capture_.clock.shift_wall(std::chrono::hours(-24));
  EXPECT_THAT(error_of([&] { session->begin_attempt("x0_001", 300.0); }),
              AllOf(HasSubstr("2025-12-31 00:00:02 UTC"), HasSubstr("2026-01-01 00:00:02 UTC"),
                    HasSubstr("set the clock")));
  EXPECT_EQ(count("attempt"), 2);
}

TEST_F(SessionTest, OpeningAMissingSessionCreatesNothing) {
  EXPECT_THAT(error_of([&] { Session::open(directory_ / "none", &capture_.clock); }),
              HasSubstr("not a session"));
  EXPECT_FALSE(fs::exists(directory_ / "none"));
}

// Root may write anywhere, so this can only be tested as another user.
TEST_F(SessionTest, OnAReadOnlyDiskIsReadButNotResumed) {
  capture_.capture_missing(capture_.open().get());
  chmod(directory_.path().c_str(), 0755);
  chmod(capture_.directory.c_str(), 0555);
  constexpr uid_t kNobody = 65534;
  const bool was_root = geteuid() == 0 && seteuid(kNobody) == 0;
  if (eaccess(capture_.directory.c_str(), W_OK) != 0) {
    EXPECT_THAT(error_of_opening(),
                AllOf(HasSubstr("cannot"), HasSubstr(capture_.directory.string())));
    EXPECT_EQ(error_of([this] { EXPECT_EQ(contents().frames.size(), 3U); }), "no error");
  }
  ASSERT_TRUE(!was_root || seteuid(0) == 0);
  chmod(capture_.directory.c_str(), 0755);
}

TEST(SessionTimesTest, KeepMicrosecondsAndReadAsUtc) {
  const std::int64_t utc_us = 1767225609123456;
  EXPECT_EQ(utc_us_from(wall_time_from(utc_us)), utc_us);
  EXPECT_EQ(utc_text(utc_us), "2026-01-01 00:00:09 UTC");
  EXPECT_EQ(utc_text(-1), "1969-12-31 23:59:59 UTC");
}

}  // namespace
}  // namespace raywalk::capture
