// Damaged sessions: whatever happened to the database or the frames, nothing wrong is exported.
#include <gmock/gmock.h>

#include <fstream>
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
#include "core/files/test_directory.h"

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
      captured = session_status(&reader)["captured"].get<int>();
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

// About 60 places; of a small database most bytes are zero.
TEST_F(SessionDamageTest, AFlippedByteIsAnErrorOrAnotherValueNeverACrash) {
  const std::string sound = read_file(file());
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
  const std::string of_attempt = " WHERE id = 2";
  expect_value_refused("UPDATE attempt SET measured_mm = NULL" + of_attempt,
                       "measured_mm of station x0_001 is NULL; it must be a number from -1");
  expect_value_refused("UPDATE attempt SET measured_mm = 1e308" + of_attempt,
                       "measured_mm of station x0_001 is '1.0e+308'");
  expect_value_refused("UPDATE attempt SET measured_mm = 9e999" + of_attempt,
                       "measured_mm of station x0_001 is 'Inf'");
  expect_value_refused("UPDATE attempt SET measured_mm = 0" + of_attempt,
                       "measured_mm of station x0_001 is 0, but the station is planned at 800 mm");
  expect_value_refused("UPDATE attempt SET exposed_utc_us = 9223372036854775807" + of_attempt,
                       "exposed_utc_us of station x0_001 is '9223372036854775807'");
  expect_value_refused("UPDATE attempt SET number = -1" + of_attempt,
                       "number of station x0_001 is '-1'");
  expect_value_refused("UPDATE frame SET bytes = 0 WHERE id = 3", "bytes of frame frames/x0_002");
  expect_value_refused("UPDATE frame SET exposure = 1 WHERE id = 3", "exposure of frame");
  expect_value_refused("UPDATE station SET planned_mm = 1e300 WHERE name = 'x0_001'",
                       "planned_mm of station x0_001 is '1.0e+300'");
  expect_value_refused("UPDATE session SET frames = ''", "frames of the session is ''");
  expect_value_refused("PRAGMA ignore_check_constraints = ON; UPDATE line SET axis = 'y'",
                       "damaged: ");
  expect_value_refused("PRAGMA ignore_check_constraints = ON; UPDATE session SET bracket_ev = '[]'",
                       "damaged: ");
  expect_value_refused("PRAGMA ignore_check_constraints = ON; UPDATE session SET bracket_ev = '['",
                       "session.db: ");
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

}  // namespace
}  // namespace raywalk::capture
