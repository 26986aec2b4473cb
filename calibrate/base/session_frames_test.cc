#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/test_capture_folder.h"
#include "core/base/test_error.h"

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
    session_->add_line("x0", "x", 0.5);
    session_->add_station("x0_000", 0.1);
    session_->add_station("x0_001", 0.2);
    session_->add_line("v0", "z", 0.25, true);
    session_->add_station("v0_000", 0.1);
    session_->add_station("v0_001", 0.3);
    session_->plan(lenses.size() == 2 ? "dual-fisheye" : "panorama", 2);
    // Rows out of order; the feedback has x0_001 before x0_000.
    for (const std::string& lens : lenses) {
      session_->add_frame("v0_001", 300.0, lens);
      session_->add_frame("x0_000", 190.0, lens);
      session_->add_frame("x0_001", 110.0, lens);
      session_->add_frame("v0_000", 100.0, lens);
    }
  }
  std::string error(bool partial = false, int exposure = 0) const {
    return error_of([&] {
      read_capture_set({.directory = folder_.path(), .exposure = exposure, .partial = partial});
    });
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
  EXPECT_EQ(set.frames[1].nominal_m, Eigen::Vector3d(0.19, 0.0, 0.5));
  EXPECT_EQ(set.frames[1].file, folder_ / "frames/x0_000_both_0.png");
  EXPECT_EQ(set.frames[1].sha256, TestSession::sum_of("both"));
  EXPECT_EQ(set.frames[2].line, 1);
  EXPECT_EQ(set.rail_m(3), 0.3);
}

TEST_F(SessionFramesTest, EveryPlacementOfTheRailIsALineOfItsOwn) {
  session_.emplace(&folder_);
  session_->add_line("x0", "x", 0.5);
  for (int i = 0; i < 4; ++i) {  // two placements of two stations, 0.1 m apart
    session_->add_station(fmt::format("x0_{:03}", i), 0.1 * i, i < 2 ? 0.0 : 0.2);
  }
  session_->plan("panorama");
  for (int i = 0; i < 4; ++i) session_->add_frame(fmt::format("x0_{:03}", i), i % 2 * 100.0);
  const CaptureSet set = folder_.read();
  ASSERT_EQ(set.lines.size(), 2U);
  EXPECT_EQ(set.lines[0].id, "x0");
  EXPECT_EQ(set.lines[1].id, "x0-2");
  EXPECT_THAT(set.lines[1].frames, ElementsAre(2, 3));
  EXPECT_NEAR(set.frames[3].nominal_m.x(), 0.3, 1e-12);
}

TEST_F(SessionFramesTest, TwoFilesOfAStationAreOneFrame) {
  write_session({"back", "front"});
  const CaptureSet set = folder_.read();
  EXPECT_EQ(set.layout, FrameLayout::kDualFisheye);
  ASSERT_EQ(set.frames.size(), 4U);
  EXPECT_EQ(set.frames[0].file, folder_ / "frames/x0_001_front_0.png");
  EXPECT_EQ(set.frames[0].back, folder_ / "frames/x0_001_back_0.png");
  EXPECT_EQ(set.frames[0].sha256, TestSession::sum_of("front") + TestSession::sum_of("back"));
  session_->execute("DELETE FROM frame WHERE file = 'frames/v0_000_back_0.png'");
  EXPECT_THAT(error(), AllOf(HasSubstr("v0_000"), HasSubstr("back lens")));
  session_->execute("DELETE FROM frame WHERE file = 'frames/x0_001_front_0.png'");
  EXPECT_THAT(error(), AllOf(HasSubstr("x0_001"), HasSubstr("front")));
}

TEST_F(SessionFramesTest, OneExposureOfABracketIsRead) {
  write_session();
  for (const bool partial : {false, true}) {
    EXPECT_THAT(error(partial, 1), HasSubstr("0 of 4 stations are captured (exposure 1)"));
  }
  for (const char* name : {"x0_000", "x0_001"}) session_->add_frame(name, 100.0, "both", 1);
  EXPECT_THAT(error(false, 1), AllOf(HasSubstr("2 of 4 stations"), HasSubstr("--partial")));
  const CaptureSet set =
      read_capture_set({.directory = folder_.path(), .exposure = 1, .partial = true});
  EXPECT_EQ(set.frames.size(), 2U);
  EXPECT_EQ(set.lines.size(), 1U);  // nothing of v0
  EXPECT_THROW(read_capture_set({.directory = folder_.path(), .exposure = 2}), UsageError);
  EXPECT_THROW(read_capture_set({.directory = folder_.path(), .exposure = -1}), UsageError);
}

TEST_F(SessionFramesTest, FramesOutsideOfTheDirectoryAreRefused) {
  write_session();
  session_->execute("UPDATE frame SET file = '../a.png' WHERE file LIKE '%x0_000%'");
  EXPECT_THAT(error(), HasSubstr("'../a.png', which is not in its directory"));
  session_->execute("UPDATE frame SET file = '/etc/passwd' WHERE file LIKE '%a.png'");
  EXPECT_THAT(error(), HasSubstr("not in its directory"));
}

// Such values reached the steps, some of which crashed, and some were taken for 0.
TEST_F(SessionFramesTest, PlacesThatAreNoneAreRefused) {
  write_session();
  for (const std::string value : {"1e308", "-1e308", "9e999", "NULL", "1e6", "-900"}) {
    session_->execute("UPDATE attempt SET measured_mm = " + value + " WHERE station_id = 1");
    EXPECT_THAT(error(), AllOf(HasSubstr("session.db: damaged: measured_mm of station x0_000 is"),
                               HasSubstr("restore")))
        << value;
  }
  session_->execute("UPDATE attempt SET measured_mm = 150 WHERE station_id IN (1, 2)");
  EXPECT_THAT(error(), HasSubstr("are at the same place of their line, x = 0.15 m"));
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

TEST_F(SessionFramesTest, LostRowsAndMissingOrTruncatedFramesAreRefused) {
  write_session();
  std::filesystem::resize_file(folder_ / "frames/x0_001_both_0.png", 10);
  EXPECT_THAT(error(), AllOf(HasSubstr("x0_001_both_0.png"), HasSubstr("10 bytes")));
  std::filesystem::remove(folder_ / "frames/x0_001_both_0.png");
  EXPECT_THAT(error(true), AllOf(HasSubstr("x0_001_both_0.png"), HasSubstr("No such file"),
                                 HasSubstr("restore")));
  session_->execute("DELETE FROM attempt");
  EXPECT_THAT(error(true), HasSubstr("refer to missing rows"));
}

TEST_F(SessionFramesTest, AnExportBesideTheSessionIsNotReadButOtherFramesAreRefused) {
  write_session();
  folder_.write_list("frames/x0_000_both_0.png,0,0,0\n./frames/x0_001_both_0.png,1,0,0\n");
  EXPECT_EQ(error(), "no error");
  EXPECT_EQ(folder_.read().frames[1].nominal_m.x(), 0.19);
  folder_.write_list("frames/x0_000_both_0.png,0,0,0\nmine.jpg,1,0,0\n");
  EXPECT_THAT(error(), AllOf(HasSubstr("holds a capture session, and a poses.csv"),
                             HasSubstr("'mine.jpg'"), HasSubstr("move poses.csv")));
}

}  // namespace
}  // namespace raywalk::calibrate
