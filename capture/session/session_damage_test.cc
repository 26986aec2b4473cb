// Whatever happened to the database or the frames, nothing wrong is believed or exported.
#include <gmock/gmock.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "capture/session/session_database.h"
#include "capture/session/session_frames.h"
#include "capture/session/session_status.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/session/session_schema.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

namespace fs = std::filesystem;

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
  std::string error_of_writing() {
    return error_of([&] { open_session_to_write(capture_.directory); });
  }
};

TEST_F(SessionDatabaseTest, SyncsEveryCommitAndEnforcesForeignKeys) {
  SqliteConnection connection = open_session_to_write(capture_.directory);
  EXPECT_EQ(connection.text("PRAGMA journal_mode"), "wal");
  EXPECT_EQ(connection.integer("PRAGMA synchronous"), 2);  // FULL
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
    EXPECT_THAT(error_of_writing(), message);
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
  int captured() {
    SessionReader reader(capture_.directory);
    return session_status(&reader)["captured"].get<int>();
  }
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

}  // namespace
}  // namespace raywalk::capture
