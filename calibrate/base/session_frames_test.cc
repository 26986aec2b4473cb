#include "calibrate/base/session_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "calibrate/base/test_capture_folder.h"
#include "core/base/error.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class SessionFramesTest : public ::testing::Test {
 protected:
  // A line along x and a validation line along z, two stations each.
  void write_session(const std::vector<std::string>& lenses = {"both"}) {
    session_.emplace(&folder_);
    session_->describe(lenses.size() == 2 ? "dual-fisheye" : "panorama", 2);
    session_->add_line("x0", "x", 0.5);
    session_->add_line("v0", "z", 0.25, true);
    for (const char* name : {"x0_000", "x0_001", "v0_000", "v0_001"}) session_->add_station(name);
    // Rows out of order; the feedback has x0_001 before x0_000.
    for (const std::string& lens : lenses) {
      session_->add_frame("v0_001", "v0", {0.25, 0.3}, lens);
      session_->add_frame("x0_000", "x0", {0.2, 0.5}, lens);
      session_->add_frame("x0_001", "x0", {0.1, 0.5}, lens);
      session_->add_frame("v0_000", "v0", {0.25, 0.1}, lens);
    }
  }
  std::string error(bool partial = false, int exposure = 0) const {
    try {
      read_capture_set({.directory = folder_.path(), .exposure = exposure, .partial = partial});
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }

  TestCaptureFolder folder_;
  std::optional<TestSession> session_;
};

TEST_F(SessionFramesTest, StationsAreInOrderOfTheFeedback) {
  write_session();
  const CaptureSet set = folder_.read();
  EXPECT_EQ(set.layout, FrameLayout::kPanorama);
  ASSERT_EQ(set.lines.size(), 2U);
  EXPECT_EQ(set.lines[0].id, "x0");
  EXPECT_EQ(set.lines[1].id, "v0");
  EXPECT_TRUE(set.lines[1].validation);
  EXPECT_EQ(set.lines[1].axis, LineAxis::kZ);
  EXPECT_THAT(set.lines[1].frames, ElementsAre(2, 3));
  ASSERT_EQ(set.frames.size(), 4U);
  EXPECT_EQ(set.frames[0].name, "x0_001");
  EXPECT_EQ(set.frames[1].name, "x0_000");
  EXPECT_EQ(set.frames[1].nominal_m, Eigen::Vector3d(0.2, 0.0, 0.5));
  EXPECT_EQ(set.frames[1].file, folder_ / "frames/x0_000_both_0.png");
  EXPECT_EQ(set.frames[1].sha256, "sha-both");
  EXPECT_EQ(set.frames[2].line, 1);
  EXPECT_EQ(set.rail_m(3), 0.3);
}

TEST_F(SessionFramesTest, TwoFilesOfAStationAreOneFrame) {
  write_session({"back", "front"});
  const CaptureSet set = folder_.read();
  EXPECT_EQ(set.layout, FrameLayout::kDualFisheye);
  ASSERT_EQ(set.frames.size(), 4U);
  EXPECT_EQ(set.frames[0].file, folder_ / "frames/x0_001_front_0.png");
  EXPECT_EQ(set.frames[0].back, folder_ / "frames/x0_001_back_0.png");
  EXPECT_EQ(set.frames[0].sha256, "sha-frontsha-back");
  session_->execute("DELETE FROM captured_frame WHERE station = 'v0_000' AND lens = 'back'");
  EXPECT_THAT(error(), AllOf(HasSubstr("v0_000"), HasSubstr("back lens")));
  session_->execute("DELETE FROM captured_frame WHERE station = 'x0_001' AND lens = 'front'");
  EXPECT_THAT(error(), AllOf(HasSubstr("x0_001"), HasSubstr("front")));
}

TEST_F(SessionFramesTest, OneExposureOfABracketIsRead) {
  write_session();
  EXPECT_THAT(error(false, 1), HasSubstr("0 of 4 stations are captured (exposure 1)"));
  EXPECT_THAT(error(true, 1), HasSubstr("0 of 4"));
  for (const char* name : {"x0_000", "x0_001"}) {
    session_->add_frame(name, "x0", {name[5] == '0' ? 0.2 : 0.1, 0.5}, "both", 1);
  }
  const CaptureSet set =
      read_capture_set({.directory = folder_.path(), .exposure = 1, .partial = true});
  EXPECT_EQ(set.frames.size(), 2U);
  EXPECT_EQ(set.lines.size(), 1U);  // nothing of v0
  EXPECT_THROW(read_capture_set({.directory = folder_.path(), .exposure = 2}), UsageError);
  EXPECT_THROW(read_capture_set({.directory = folder_.path(), .exposure = -1}), UsageError);
}

TEST_F(SessionFramesTest, UnfinishedSessionIsRefusedUnlessPartial) {
  write_session();
  session_->add_station("x0_002");
  EXPECT_THAT(error(), AllOf(HasSubstr("4 of 5 stations"), HasSubstr("--partial")));
  EXPECT_EQ(error(true), "no error");
}

TEST_F(SessionFramesTest, FramesOutsideOfTheDirectoryAreRefused) {
  write_session();
  session_->execute("UPDATE captured_frame SET file = '../a.png' WHERE station = 'x0_000'");
  EXPECT_THAT(error(), HasSubstr("'../a.png', which is not in its directory"));
  session_->execute("UPDATE captured_frame SET file = '/etc/passwd' WHERE station = 'x0_000'");
  EXPECT_THAT(error(), HasSubstr("not in its directory"));
}

// Such values reached the steps, some of which crashed, and some were taken for 0.
TEST_F(SessionFramesTest, PlacesThatAreNoneAreRefused) {
  struct Damage {
    std::string value;
    std::string shown;
  };
  for (const auto& [value, shown] :
       {Damage{"1e308", "x0_000: the captured x_m is 1e+308"},
        Damage{"-1e308", "x0_000: the captured x_m is -1e+308"},
        Damage{"1e6 + 1", "x0_000: the captured x_m is 1e+06"},
        Damage{"9e999", "x0_000: the captured x_m is inf"},
        Damage{"NULL", "x0_000: the captured x_m is missing or not a number"},
        Damage{"'near'", "x0_000: the captured x_m is missing or not a number"},
        Damage{"1e-308", "x0_000 was captured at x = 1e-308 m, z = 0.5 m, but planned at x = 0.2"},
        Damage{"900", "x0_000 was captured at x = 900 m"}}) {
    SCOPED_TRACE(value);
    session_.reset();
    std::filesystem::remove(folder_ / "session.db");
    write_session();
    session_->execute("UPDATE captured_frame SET x_m = " + value + " WHERE station = 'x0_000'");
    EXPECT_THAT(error(),
                AllOf(HasSubstr("session.db: damaged: "), HasSubstr(shown), HasSubstr("restore")));
  }
}

TEST_F(SessionFramesTest, PlanThatIsNoneIsRefused) {
  write_session();
  session_->execute("UPDATE line SET across_m = 7");
  EXPECT_THAT(error(), HasSubstr("not on its line x0 (across_m is 7)"));
  session_->execute("UPDATE station SET z_m = 1e308 WHERE name = 'v0_001'");
  EXPECT_THAT(error(), HasSubstr("v0_001: the planned z_m is 1e+308"));
  session_->execute("DELETE FROM station WHERE name = 'v0_001'");
  EXPECT_THAT(error(), HasSubstr("v0_001: the planned x_m is missing"));
  session_->execute("UPDATE line SET across_m = 1e308");
  EXPECT_THAT(error(), HasSubstr("line x0: across_m is 1e+308"));
  session_->execute("UPDATE line SET axis = 'y'");
  EXPECT_THAT(error(), HasSubstr("line x0: axis is 'y'"));
}

TEST_F(SessionFramesTest, StationsAtOnePlaceAreRefused) {
  write_session();
  session_->execute(
      "UPDATE captured_frame SET x_m = 0.15 WHERE line = 'x0';"
      "UPDATE station SET x_m = 0.15 WHERE name LIKE 'x0%'");
  EXPECT_THAT(error(), HasSubstr("x0_000 and x0_001 are at the same place of their line"));
}

TEST_F(SessionFramesTest, SessionWithoutStationsIsRefused) {
  write_session();
  session_->execute("DELETE FROM captured_frame; DELETE FROM station; DELETE FROM line");
  for (const bool partial : {false, true}) {
    EXPECT_THAT(error(partial), AllOf(HasSubstr("session.db"), HasSubstr("plans no stations")));
  }
}

// The names of stations and lines are parts of file names.
TEST_F(SessionFramesTest, NamesThatAreNoFileNamesAreRefused) {
  write_session();
  for (const char* name : {"../../x", "", "..", "a/b", "a\nb", "a\x1b[31m"}) {
    SCOPED_TRACE(name);
    session_->execute(
        fmt::format("UPDATE captured_frame SET station = '{}' WHERE x_m = 0.2", name));
    EXPECT_THAT(error(), HasSubstr("a station has the name " + excerpt(name)));
  }
  session_->execute("UPDATE captured_frame SET station = 'x0_001' WHERE x_m = 0.2");
  EXPECT_THAT(error(), HasSubstr("x0_001 has several frames"));
  session_->execute("UPDATE captured_frame SET lens = 'left' WHERE station = 'x0_001'");
  EXPECT_THAT(error(), HasSubstr("lens is 'left'"));
  session_->execute("UPDATE line SET name = '/' WHERE name = 'x0'");
  EXPECT_THAT(error(), HasSubstr("a line has the name '/'"));
}

TEST_F(SessionFramesTest, UnknownLayoutOrExposuresAreRefused) {
  write_session();
  session_->execute("UPDATE session SET exposures = 'two'");
  EXPECT_THAT(error(), HasSubstr("exposures in the table session"));
  session_->execute("UPDATE session SET frames = 'flat'");
  EXPECT_THAT(error(), HasSubstr("'flat', neither 'panorama' nor 'dual-fisheye'"));
  session_->execute("DROP TABLE captured_frame");
  session_->execute("UPDATE session SET frames = 'panorama', exposures = 1");
  EXPECT_THAT(error(), AllOf(HasSubstr("no such table"), HasSubstr("damaged")));
}

TEST_F(SessionFramesTest, OtherDatabasesAreRefused) {
  write_session();
  session_->execute("PRAGMA user_version = 2");
  EXPECT_THAT(error(), HasSubstr("newer raywalk-capture"));
  session_->execute("PRAGMA user_version = 1; DELETE FROM session");
  EXPECT_THAT(error(), HasSubstr("damaged"));
  session_->execute("PRAGMA application_id = 1");
  EXPECT_THAT(error(), HasSubstr("not a session"));
  session_.reset();
  write_file_atomically(folder_ / "session.db", std::string(5000, 'x'));
  EXPECT_THAT(error(), HasSubstr("session.db"));
}

}  // namespace
}  // namespace raywalk::calibrate
