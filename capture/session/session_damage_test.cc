// Damaged sessions: whatever happened to the database or the frames, nothing wrong is exported.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <vector>

#include "capture/session/session_database.h"
#include "capture/session/session_export.h"
#include "capture/session/session_status.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/session/session_schema.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

namespace fs = std::filesystem;

class SessionDamageTest : public testing::Test {
 protected:
  // Captured once, because every station is synced to the disk.
  static void SetUpTestSuite() {
    captured_once_ = std::make_unique<TestDirectory>();
    TestCapture capture{.directory = *captured_once_ / "session", .plan = test_plan(true)};
    capture.off_mm = 0.25;
    capture.capture_missing(capture.open().get());
  }
  static void TearDownTestSuite() { captured_once_.reset(); }
  SessionDamageTest() {
    fs::copy(*captured_once_ / "session", capture_.directory, fs::copy_options::recursive);
  }

  fs::path file() const { return session_database_path(capture_.directory); }
  // What the export writes, or an empty text after an error.
  std::string exported() {
    for (const char* list : {"poses.csv", "gt.csv"}) fs::remove(capture_.directory / list);
    message_ = error_of([&] {
      SessionReader reader(capture_.directory);
      export_session(&reader, {.partial = partial_});
    });
    if (!message_.empty()) {
      EXPECT_FALSE(fs::exists(capture_.directory / "poses.csv"));
      return "";
    }
    return read_file(capture_.directory / "poses.csv") + read_file(capture_.directory / "gt.csv");
  }
  // The number of stations that the status calls captured; none after an error.
  std::optional<int> captured() {
    std::optional<int> captured;
    error_of([&] {
      SessionReader reader(capture_.directory);
      captured = status_of(&reader).captured();
    });
    return captured;
  }
  // Changes the database behind the program's back.
  void change(const std::string& sql) {
    SqliteConnection(file(), SqliteAccess::kReadWrite).execute("PRAGMA synchronous = OFF;" + sql);
  }
  // Without syncing, which takes most of the time.
  void write(const std::string& database) { std::ofstream(file(), std::ios::binary) << database; }
  void expect_refused(const testing::Matcher<std::string>& message) {
    EXPECT_EQ(exported(), "");
    EXPECT_THAT(message_, AllOf(message, Not(HasSubstr("\n"))));
  }
  void expect_value_refused(const std::string& sql, const std::string& message) {
    const std::string sound = read_file(file());
    change(sql);
    expect_refused(HasSubstr(message));
    EXPECT_THAT(error_of([&] { capture_.open(); }), HasSubstr(message)) << sql;
    write(sound);
  }

  static inline std::unique_ptr<TestDirectory> captured_once_;
  TestDirectory directory_;
  TestCapture capture_{.directory = directory_ / "session", .plan = test_plan(true)};
  std::string message_;
  bool partial_ = false;
};

// The places to damage: about 60, or, with RAYWALK_FLIP_STRIDE, every so many bytes of the file.
std::vector<std::size_t> places_of(const std::string& sound) {
  const char* stride = std::getenv("RAYWALK_FLIP_STRIDE");
  std::vector<std::size_t> used;  // most of a small database is empty
  for (std::size_t at = 0; at < sound.size(); ++at) {
    if (stride != nullptr || sound[at] != '\0') used.push_back(at);
  }
  const std::size_t step =
      stride == nullptr ? used.size() / 60 : static_cast<std::size_t>(std::atoi(stride));
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < used.size(); i += step) places.push_back(used[i]);
  return places;
}

TEST_F(SessionDamageTest, AFlippedByteIsFoundOrChangesNothing) {
  const std::string sound = read_file(file());
  const std::string expected = exported();
  const unsigned char flips[] = {0x01, 0xFF, 0x80, 0x10};
  int found = 0, tried = 0;
  for (const std::size_t at : places_of(sound)) {
    std::string damaged = sound;
    damaged[at] = static_cast<char>(damaged[at] ^ flips[tried % std::size(flips)]);
    write(damaged);
    partial_ = tried++ % 2 == 0;
    const std::string written = exported();
    if (written.empty()) {
      ++found;
      EXPECT_THAT(message_, AllOf(HasSubstr("session"), Not(HasSubstr("\n")))) << at;
    } else {
      EXPECT_EQ(written, expected) << at;
    }
    EXPECT_EQ(captured().value_or(15), 15) << at;
  }
  EXPECT_GT(found, std::getenv("RAYWALK_FLIP_STRIDE") != nullptr ? 0 : tried / 2);
}

TEST_F(SessionDamageTest, EveryByteOfAMeasuredPositionCounts) {
  const std::string sound = read_file(file());
  const double measured_mm = 800.25;  // of x0_001
  std::string bytes(8, '\0');
  std::memcpy(bytes.data(), &measured_mm, 8);
  std::reverse(bytes.begin(), bytes.end());  // SQLite stores numbers big-endian
  const std::size_t place = sound.find(bytes);
  ASSERT_NE(place, std::string::npos);
  for (std::size_t at = place; at < place + 8; ++at) {
    std::string damaged = sound;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write(damaged);
    expect_refused(HasSubstr("session.db"));
  }
}

TEST_F(SessionDamageTest, ValuesOutOfRangeAreRefused) {
  const std::string of_attempt = " WHERE id = 2";
  expect_value_refused("UPDATE attempt SET measured_mm = NULL" + of_attempt,
                       "measured_mm of station x0_001 is NULL");
  expect_value_refused("UPDATE attempt SET measured_mm = 1e308" + of_attempt,
                       "measured_mm of station x0_001 is 1e+308");
  expect_value_refused("UPDATE attempt SET measured_mm = 9e999" + of_attempt,
                       "measured_mm of station x0_001 is inf");
  expect_value_refused("UPDATE attempt SET measured_mm = 0" + of_attempt,
                       "measured_mm of station x0_001 is 0, but the station is planned at 800 mm");
  expect_value_refused("UPDATE attempt SET exposed_utc_us = 9223372036854775807" + of_attempt,
                       "exposed_utc_us of station x0_001 is '9223372036854775807'");
  expect_value_refused("UPDATE attempt SET number = -1" + of_attempt,
                       "number of station x0_001 is '-1'");
  expect_value_refused("UPDATE frame SET bytes = -5 WHERE id = 3", "bytes of frame frames/x0_002");
  expect_value_refused("UPDATE frame SET bytes = 0 WHERE id = 3", "bytes of frame frames/x0_002");
  expect_value_refused("UPDATE frame SET sha256 = 'none' WHERE id = 3", "hexadecimal digits");
  expect_value_refused("UPDATE frame SET exposure = 1 WHERE id = 3", "exposure of frame");
  expect_value_refused("UPDATE frame SET width_px = 0 WHERE id = 3", "width_px of frame");
  expect_value_refused("UPDATE session SET exposures = 0", "exposures of the session is '0'");
  expect_value_refused("UPDATE session SET frames = ''", "frames of the session is ''");
}

TEST_F(SessionDamageTest, ValuesOfTheWrongTypeAreRefused) {
  const std::string weak =
      "PRAGMA writable_schema = ON; UPDATE sqlite_master SET sql = replace(sql, 'STRICT', '') "
      "WHERE name = 'attempt';";
  expect_value_refused(weak, "the definition of 'attempt' was changed");
  expect_value_refused("PRAGMA ignore_check_constraints = ON; UPDATE line SET axis = 'y'",
                       "damaged: ");
}

TEST_F(SessionDamageTest, StationsAndLinesMustBeThoseOfThePlan) {
  expect_value_refused(
      "DELETE FROM frame WHERE attempt_id = 15; DELETE FROM attempt WHERE id = 15;"
      "DELETE FROM station WHERE id = 15",
      "station v0_002 differs between its tables and its plan");
  expect_value_refused("INSERT INTO station VALUES (16, 5, 3, 'v0_003', 1, 0, 999)",
                       "its tables hold 16 stations, its plan (plan_json) 15");
  expect_value_refused("UPDATE station SET x_m = x_m + 0.001 WHERE name = 'x0_001'",
                       "the place of station x0_001");
  expect_value_refused("UPDATE station SET planned_mm = 1e300 WHERE name = 'x0_001'",
                       "planned_mm of station x0_001 is 1e+300");
  expect_value_refused("UPDATE station SET name = 'x0_009' WHERE name = 'x0_001'",
                       "station x0_001 differs");
  expect_value_refused("UPDATE line SET validation = 1 WHERE name = 'x0'", "validation of line x0");
  expect_value_refused("UPDATE line SET across_m = 3 WHERE name = 'x0'", "across_m of line x0");
  expect_value_refused("INSERT INTO line VALUES (9, 'x9', 'x', 0, 0)", "its tables hold 6 lines");
  expect_value_refused("UPDATE session SET plan_json = '{}'", "plan_json: ");
  expect_value_refused("UPDATE session SET plan_json = 'no JSON'", "plan_json: ");
  expect_value_refused("DELETE FROM session", "the table session has no row");
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
  std::ofstream(frame) << sound.substr(0, 100);
  expect_refused(HasSubstr("x0_001.jpg (station x0_001): 100 bytes"));
  EXPECT_EQ(captured(), 14);
  std::string altered = sound;
  altered[500] ^= 1;
  std::ofstream(frame) << altered;
  expect_refused(HasSubstr("x0_001.jpg (station x0_001): changed since it was written"));
  std::ofstream(frame) << sound;
  EXPECT_NE(exported(), "");
}

// Such sessions are read as they are, and protected once they are written to.
TEST_F(SessionDamageTest, ASessionOfAnEarlierProgramHasNoCopies) {
  const std::string expected = exported();
  for (const char* table : {"session", "line", "station", "attempt", "frame", "event", "journal"}) {
    change(fmt::format("DROP INDEX {}_copy", table));
  }
  EXPECT_EQ(exported(), expected);
  capture_.open();
  EXPECT_EQ(open_session_to_read(capture_.directory)
                .integer("SELECT count(*) FROM sqlite_master WHERE name LIKE '%_copy'"),
            7);
  EXPECT_EQ(exported(), expected);
}

// Every column is in the copy of its table.
TEST_F(SessionDamageTest, TheCopiesHoldEveryColumn) {
  SqliteConnection database = open_session_to_read(capture_.directory);
  SqliteStatement table(&database, "SELECT name FROM sqlite_master WHERE type = 'table'");
  while (table.step()) {
    const std::string name = table.text(0);
    EXPECT_EQ(database.integer("SELECT count(*) FROM pragma_table_info('" + name + "')"),
              1 + database.integer("SELECT count(*) FROM pragma_index_info('" + name + "_copy')"))
        << name;
  }
}

}  // namespace
}  // namespace raywalk::capture
