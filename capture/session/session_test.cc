#include "capture/session/session.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/session/session_schema.h"

// Stand-ins for functions of the C library, in this program and in SQLite.
namespace {

std::vector<std::string> synced;  // what was synced, in order; of a folder with what it holds
int full_at = -1;                 // the sync, from 0, at which the disk is full; -1: never

int record_sync(int descriptor, int call) {
  namespace fs = std::filesystem;
  const fs::path path = fs::read_symlink("/proc/self/fd/" + std::to_string(descriptor));
  std::string text = path.filename().string();
  if (text == "frames") {
    for (const auto& entry : fs::directory_iterator(path)) {
      text += " " + entry.path().filename().string();
    }
  }
  synced.push_back(text);
  if (full_at == static_cast<int>(synced.size()) - 1) {
    errno = ENOSPC;
    return -1;
  }
  return static_cast<int>(syscall(call, descriptor));
}

}  // namespace

extern "C" int fsync(int descriptor) { return record_sync(descriptor, SYS_fsync); }
extern "C" int fdatasync(int descriptor) { return record_sync(descriptor, SYS_fdatasync); }

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

class SessionTest : public SessionCase {};

TEST_F(SessionTest, KeepsEveryTimeOfAStation) {
  capture_.capture_missing(capture_.open().get(), 1);
  EXPECT_EQ(count("attempt WHERE begun_utc_us = 1767225600000000"), 1);  // 2026-01-01
  for (const std::string time : {"triggered", "exposed", "ended"}) {
    EXPECT_EQ(count("attempt WHERE " + time + "_utc_us = begun_utc_us + 2500000"), 1) << time;
  }
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
  const SessionVerification verification = capture_.verify();
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

TEST_F(SessionTest, ConfigurationAndExposureStay) {
  {
    const std::unique_ptr<Session> session = capture_.open();
    EXPECT_EQ(session->exposure(), "");
    session->set_exposure(R"({"iso": 200})");
  }
  EXPECT_EQ(capture_.open()->exposure(), R"({"iso": 200})");
  const SessionFacts facts = SessionReader(capture_.directory).facts();
  EXPECT_EQ(facts.created, capture_.clock.wall_now());
  EXPECT_EQ(facts.config_text, "camera:\n  kind: osc\n");
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

// --- Whatever happened to the database or the frames, nothing wrong is believed or exported ------

class SessionDatabaseTest : public SessionCase {
 protected:
  // A session without captured stations, in a folder whose name has what URIs reserve.
  SessionDatabaseTest() {
    capture_.directory = directory_ / "100%?#";
    capture_.open();
  }
  std::string error_of_reading() {
    return error_of([&] { open_session_to_read(capture_.directory); });
  }
};

TEST_F(SessionDatabaseTest, EnforcesForeignKeys) {
  SqliteConnection connection = open_session_to_write(capture_.directory);
  EXPECT_THROW(connection.execute("INSERT INTO station VALUES (999, 999, 0, 'lost', 0, 0, 0)"),
               Error);
}

TEST_F(SessionDatabaseTest, SaysThatTheDiskIsFullOrItCannotBeWritten) {
  SqliteConnection connection = open_session_to_write(capture_.directory);
  connection.execute("PRAGMA max_page_count = 1");
  SqliteStatement add(&connection, "INSERT INTO event (at_utc_us, kind, text) VALUES (0, '', ?1)");
  EXPECT_THAT(error_of([&] { add.bind(std::string(1 << 20, 'x')).run(); }),
              AllOf(HasSubstr("session.db"), HasSubstr("disk is full")));
  connection.execute("PRAGMA max_page_count = 1000000");
  EXPECT_NO_THROW(add.bind("fits").run());
  SqliteConnection reader = open_session_to_read(capture_.directory);
  EXPECT_THAT(error_of([&] { reader.execute("DELETE FROM station"); }),
              AllOf(HasSubstr("session.db"), HasSubstr("cannot be written")));
}

TEST_F(SessionDatabaseTest, RefusesWhatIsNoSession) {
  const std::string sound = read_file(database());
  const auto overwrite = [&](const std::string& bytes) {
    std::ofstream(database(), std::ios::binary) << bytes;
  };
  struct Case {
    std::function<void()> damage;
    testing::Matcher<std::string> message;
  };
  const Case cases[] = {
      {[&] { overwrite(std::string(5000, 'x')); }, HasSubstr("not an SQLite database")},
      {[&] {
         fs::remove(database());
         change("CREATE TABLE mine (a)");
       },
       HasSubstr("not a session of raywalk-capture")},
      {[&] { change(fmt::format("PRAGMA user_version = {}", kSessionFormatVersion + 1)); },
       AllOf(HasSubstr("newer"), HasSubstr("format 2, this program reads up to 1"))},
      // Everything after the first page, which holds the file's header.
      {[&] { overwrite(sound.substr(0, 4096) + std::string(sound.size() - 4096, '\x5a')); },
       AllOf(HasSubstr("damaged"), HasSubstr("frames are untouched"))},
      {[&] { overwrite(sound.substr(0, std::size_t{3} * 4096)); }, HasSubstr("damaged")}};
  for (const Case& each : cases) {
    each.damage();
    const auto message = AllOf(HasSubstr("session.db"), each.message, Not(HasSubstr("\n")));
    EXPECT_THAT(error_of_reading(), message);
    EXPECT_THAT(error_of([&] { open_session_to_write(capture_.directory); }), message);
    overwrite(sound);
  }
  overwrite("");
  EXPECT_THAT(error_of_reading(), HasSubstr("not a session of raywalk-capture"));
}

// A dangling link in place of the log's index, which SQLite does not follow, has the effect of a
// read-only disk for every user.
TEST_F(SessionDatabaseTest, IsReadOnAReadOnlyDiskButNotWithoutTheEntriesInTheLog) {
  fs::create_symlink("nowhere", capture_.directory / "session.db-shm");
  EXPECT_EQ(count("line"), 1);
  std::ofstream(capture_.directory / "session.db-wal") << "entries";
  EXPECT_THAT(error_of_reading(),
              AllOf(HasSubstr("session.db-wal"), HasSubstr("copy the directory")));
}

class SessionDamageTest : public SessionCase {
 protected:
  // Captured once, because every station is synced to the disk.
  static void SetUpTestSuite() {
    captured_once_ = std::make_unique<TestDirectory>();
    TestCapture capture{.directory = *captured_once_ / "session", .plan = test_plan(true)};
    capture.off_mm = 0.25;
    capture.capture_missing(capture.open().get());
  }
  static void TearDownTestSuite() { captured_once_.reset(); }
  SessionDamageTest() : SessionCase(test_plan(true)) {
    fs::copy(*captured_once_ / "session", capture_.directory, fs::copy_options::recursive);
  }

  // What the export writes, or an empty text after an error.
  std::string exported() {
    for (const char* list : {"poses.csv", "gt.csv"}) fs::remove(capture_.directory / list);
    message_ = error_of([&] {
      SessionReader reader(capture_.directory);
      export_session(&reader, {.partial = partial_});
    });
    if (message_ != "no error") {
      EXPECT_FALSE(fs::exists(capture_.directory / "poses.csv"));
      return "";
    }
    return read_file(capture_.directory / "poses.csv") + read_file(capture_.directory / "gt.csv");
  }
  // The number of stations that the status calls captured.
  int captured() const { return capture_.status()["captured"].get<int>(); }
  void write(const std::string& bytes) { std::ofstream(database(), std::ios::binary) << bytes; }
  void expect_refused(const testing::Matcher<std::string>& message) {
    EXPECT_EQ(exported(), "");
    EXPECT_THAT(message_, AllOf(message, Not(HasSubstr("\n"))));
  }

  static inline std::unique_ptr<TestDirectory> captured_once_;
  std::string message_;
  bool partial_ = false;
};

// About 60 places; of a small database most bytes are zero.
TEST_F(SessionDamageTest, AFlippedByteIsAnErrorOrAnotherValueNeverACrash) {
  const std::string sound = read_file(database());
  std::vector<std::size_t> used;
  for (std::size_t at = 0; at < sound.size(); ++at) {
    if (sound[at] != '\0') used.push_back(at);
  }
  const unsigned char flips[] = {0x01, 0xFF, 0x80, 0x10};
  int found = 0, tried = 0;
  for (std::size_t i = 0; i < used.size(); i += used.size() / 60) {
    std::string damaged = sound;
    damaged[used[i]] = static_cast<char>(damaged[used[i]] ^ flips[tried++ % std::size(flips)]);
    write(damaged);
    if (!exported().empty()) continue;
    ++found;
    EXPECT_THAT(message_, AllOf(HasSubstr("session"), Not(HasSubstr("\n")))) << used[i];
  }
  EXPECT_GT(found, tried / 4);
}

TEST_F(SessionDamageTest, ValuesOutOfRangeAreRefused) {
  const std::string unchecked = "PRAGMA ignore_check_constraints = ON; UPDATE ";
  const std::pair<std::string, std::string> cases[] = {
      {"UPDATE attempt SET measured_mm = NULL WHERE id = 2",
       "measured_mm of station x0_001 is NULL; it must be a number from -1"},
      {"UPDATE attempt SET measured_mm = 1e308 WHERE id = 2",
       "measured_mm of station x0_001 is '1.0e+308'"},
      {"UPDATE attempt SET measured_mm = 9e999 WHERE id = 2",
       "measured_mm of station x0_001 is 'Inf'"},
      {"UPDATE attempt SET measured_mm = 0 WHERE id = 2",
       "measured_mm of station x0_001 is 0, but the station is planned at 800 mm"},
      {"UPDATE attempt SET exposed_utc_us = 9223372036854775807 WHERE id = 2",
       "exposed_utc_us of station x0_001 is '9223372036854775807'"},
      {"UPDATE attempt SET number = -1 WHERE id = 2", "number of station x0_001 is '-1'"},
      {"UPDATE frame SET bytes = 0 WHERE id = 3", "bytes of frame frames/x0_002"},
      {"UPDATE frame SET exposure = 1 WHERE id = 3", "exposure of frame"},
      {"UPDATE frame SET file = '/etc/passwd' WHERE id = 3", "not in its directory"},
      {"UPDATE frame SET file = 'frames/../../secret' WHERE id = 3", "not in its directory"},
      {"UPDATE station SET planned_mm = 1e300 WHERE name = 'x0_001'",
       "planned_mm of station x0_001 is '1.0e+300'"},
      {"DELETE FROM station WHERE name = 'x0_002'", "rows refer to missing rows"},
      {"UPDATE session SET mode = 'other'", "mode of the session is 'other'; it must be stations"},
      {"UPDATE session SET camera = 'other'", "camera of the session is 'other'"},
      {"UPDATE session SET frames = ''", "frames of the session is ''"},
      {unchecked + "line SET axis = 'y'", "damaged: "},
      {unchecked + "session SET bracket_ev = '[]'", "damaged: "},
      {unchecked + "session SET bracket_ev = '['", "session.db: "},
      {"DELETE FROM session", "the table session has no row"}};
  const std::string sound = read_file(database());
  for (const auto& [sql, message] : cases) {
    change(sql);
    expect_refused(HasSubstr(message));
    EXPECT_THAT(error_of_opening(), HasSubstr(message)) << sql;
    write(sound);
  }
}

TEST_F(SessionDamageTest, AFrameWithoutARowIsMissed) {
  change("DELETE FROM frame WHERE id = 2");
  expect_refused(AllOf(HasSubstr("station x0_001: has no frame"), HasSubstr("--give-up")));
  partial_ = true;
  expect_refused(HasSubstr("station x0_001"));
  EXPECT_EQ(captured(), 14);
}

TEST_F(SessionDamageTest, MissingTruncatedAndAlteredFramesAreNotExported) {
  const fs::path frame = capture_.directory / "frames/x0_001.jpg";
  const std::string sound = read_file(frame);
  fs::remove(frame);
  expect_refused(
      AllOf(HasSubstr("frames/x0_001.jpg (station x0_001): No such file"), HasSubstr("restore")));
  EXPECT_EQ(captured(), 14);
  fs::create_directory(frame);
  expect_refused(HasSubstr("x0_001.jpg (station x0_001): not a regular file"));
  fs::remove(frame);
  std::ofstream(frame) << sound.substr(0, 100);
  expect_refused(HasSubstr("x0_001.jpg (station x0_001): 100 bytes"));
  EXPECT_EQ(captured(), 14);
  std::string altered = sound;
  altered[500] ^= 1;
  std::ofstream(frame) << altered;
  expect_refused(HasSubstr("x0_001.jpg (station x0_001): changed since it was written"));
  fs::remove(capture_.directory / "frames/x0_002.jpg");
  expect_refused(
      HasSubstr("x0_001.jpg (station x0_001): changed since it was written (SHA-256 "
                "differs) (and 1 more faults)"));
}

// A frame is on the disk before the row that names it, and a full disk leaves nothing half. That a
// session survives kills at any moment is tested with the whole program (tests/end_to_end).
class DurabilityTest : public SessionCase {
 protected:
  // Captures a station whose sync number `fails` finds the disk full; -1: none does.
  std::string capture(std::size_t station, int fails = -1) {
    synced.clear();
    full_at = fails;
    const std::string error = error_of(
        [&] { capture_.capture(session_.get(), capture_.plan.lines[0].stations[station]); });
    full_at = -1;
    return error;
  }

  std::unique_ptr<Session> session_ = capture_.open();
};

TEST_F(DurabilityTest, TheAttemptThenTheFrameThenItsNameThenItsRow) {
  EXPECT_EQ(capture(0), "no error");
  EXPECT_THAT(synced,
              ElementsAre("session.db-wal", AllOf(StartsWith(".x0_000."), EndsWith(".partial.jpg")),
                          "frames x0_000.jpg", "session.db-wal"));
}

TEST_F(DurabilityTest, AFullDiskDuringAFrameLosesNothing) {
  capture(0);
  EXPECT_THAT(capture(1, 1), AllOf(HasSubstr("x0_001.jpg"), HasSubstr("free some space")));
  EXPECT_THAT(capture(1, 2), AllOf(HasSubstr("x0_001_a2.jpg"), HasSubstr("free some space")));
  EXPECT_THAT(list_frames(capture_.directory), ElementsAre("frames/x0_000.jpg"));
  capture_.capture_missing(session_.get());
  EXPECT_THAT(list_frames(capture_.directory),
              ElementsAre("frames/x0_000.jpg", "frames/x0_001_a3.jpg", "frames/x0_002.jpg"));
  EXPECT_TRUE(capture_.verify().is_whole());
}

}  // namespace
}  // namespace raywalk::capture
