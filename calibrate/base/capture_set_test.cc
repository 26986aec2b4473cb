#include "calibrate/base/capture_set.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <optional>
#include <string>

#include "calibrate/base/test_capture_folder.h"
#include "core/files/test_support.h"

namespace raywalk::calibrate {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> names_of(const CaptureSet& set) {
  std::vector<std::string> names;
  for (const CaptureFrame& frame : set.frames) names.push_back(frame.name);
  return names;
}

class CaptureSetTest : public ::testing::Test {
 protected:
  // The message of reading the folder.
  std::string error() const { return folder_.read_error(); }

  TestCaptureFolder folder_;
};

TEST_F(CaptureSetTest, FrameListIsGroupedIntoLinesInRailOrder) {
  for (const char* file : {"c.png", "b.png", "a.png"}) folder_.add_picture(file);
  folder_.write_list("c.png,0.2,1,2,0,0,0\na.png,0,1,2,5,0,0\nb.png,0.1,1,2,0,0,0\n",
                     "file,x,y,z,yaw,pitch,roll");
  const CaptureSet set = folder_.read();
  EXPECT_EQ(set.layout, FrameLayout::kPanorama);
  EXPECT_EQ(set.frame, (PanoramaSize{16, 8}));
  ASSERT_EQ(set.lines.size(), 1U);
  EXPECT_EQ(set.lines[0].axis, LineAxis::kX);
  EXPECT_NEAR(set.lines[0].across_m, 2.0, 1e-12);
  EXPECT_FALSE(set.lines[0].validation);
  EXPECT_THAT(set.lines[0].frames, ElementsAre(0, 1, 2));
  EXPECT_THAT(names_of(set), ElementsAre("a", "b", "c"));
  EXPECT_NEAR(set.rail_m(2), 0.2, 1e-12);
  ASSERT_TRUE(set.frames[0].nominal_attitude);
  EXPECT_NEAR(set.frames[0].nominal_attitude->yaw_rad, radians_from_degrees(5.0), 1e-12);
  EXPECT_FALSE(set.frames[1].nominal_attitude);
  EXPECT_EQ(indices_by_name(set).at("b"), 1U);
  EXPECT_FALSE(indices_by_name(set).contains("d"));
}

TEST_F(CaptureSetTest, FramesWithRepeatedStemsAreNamedByTheirPaths) {
  std::string rows;
  for (int i = 0; i < 3; ++i) {
    for (const char* line : {"front", "left"})
      folder_.add_picture(fmt::format("{}/{}.png", line, i));
    rows += fmt::format("front/{0}.png,0.{0},0,0.7\nleft/{0}.png,0.5,0,0.{0}\n", i);
  }
  folder_.write_list(rows);
  EXPECT_THAT(names_of(folder_.read()),
              ElementsAre("front_0", "front_1", "front_2", "left_0", "left_1", "left_2"));
}

TEST_F(CaptureSetTest, NamesAreEscaped) {
  for (const char* file : {"a\n\x1b.png", "\xFF.png", "c.png"}) folder_.add_picture(file);
  folder_.write_list("\"a\n\x1b.png\",0,0,0\n\xFF.png,0.1,0,0\nc.png,0.2,0,0\n");
  EXPECT_THAT(names_of(folder_.read()), ElementsAre(R"(a\n\u001b)", R"(\xff)", "c"));
}

TEST_F(CaptureSetTest, LinesCrossOnlyNearTheirStations) {
  folder_.write_cross();
  CaptureSet set = folder_.read();
  const std::vector<LineIntersection> intersections = intersections_of(set);
  ASSERT_EQ(intersections.size(), 1U);
  EXPECT_EQ(set.lines[intersections[0].along_x].axis, LineAxis::kX);
  EXPECT_EQ(set.lines[intersections[0].along_z].axis, LineAxis::kZ);
  EXPECT_NEAR(std::hypot(intersections[0].at.x_m, intersections[0].at.z_m), 0.0, 1e-12);
  // The line along z shifted along itself: up to one spacing beyond its end it still crosses.
  const auto shifted = [&set](double by_m) {
    CaptureSet moved = set;
    for (CaptureFrame& frame : moved.frames) {
      if (frame.line == 1) frame.nominal_m.z() += by_m;
    }
    return intersections_of(moved).size();
  };
  EXPECT_EQ(shifted(0.19), 1U);
  EXPECT_EQ(shifted(0.21), 0U);
}

TEST_F(CaptureSetTest, IntersectionOfObliqueLinesLiesOnBoth) {
  folder_.write_cross();
  CaptureSet set = folder_.read();
  // z = 0.02 + 0.05 x and x = 0.01 - 0.03 z.
  for (CaptureFrame& frame : set.frames) {
    Eigen::Vector3d& at = frame.nominal_m;
    if (frame.line == 0) at.z() = 0.02 + 0.05 * at.x();
    if (frame.line == 1) at.x() = 0.01 - 0.03 * at.z();
  }
  const std::vector<LineIntersection> intersections = intersections_of(set);
  ASSERT_EQ(intersections.size(), 1U);
  const PlanPoint at = intersections[0].at;
  EXPECT_NEAR(at.z_m, 0.02 + 0.05 * at.x_m, 1e-12);
  EXPECT_NEAR(at.x_m, 0.01 - 0.03 * at.z_m, 1e-12);
}

TEST_F(CaptureSetTest, ErrorsNameWhatIsMissingOrOfAnotherCamera) {
  EXPECT_THAT(error(), AllOf(HasSubstr(folder_.path().string()), HasSubstr("poses.csv"),
                             HasSubstr("session.db")));
  folder_.write_cross();
  folder_.add_picture("b2.png", {32, 16});
  EXPECT_THAT(error(), AllOf(HasSubstr("b2.png"), HasSubstr("32x16"), HasSubstr("16x8")));
  std::filesystem::remove(folder_ / "b1.png");
  EXPECT_THAT(error(), AllOf(HasSubstr("poses.csv:6: "), HasSubstr("b1.png: no such file")));
  EXPECT_THROW(read_capture_set({.directory = folder_ / "nothing"}), Error);
  EXPECT_THROW(read_capture_set({.directory = folder_ / "poses.csv"}), Error);
}

TEST_F(CaptureSetTest, ListedFisheyeFramesNeedNotBeTwiceAsWideAsHigh) {
  folder_.write_cross();
  for (const char* name : {"a0", "a1", "a2", "b0", "b1", "b2"}) {
    folder_.add_picture(std::string(name) + ".png", {20, 20});
  }
  EXPECT_THAT(error(), HasSubstr("not a panorama"));
  const CaptureSet set = read_capture_set({.directory = folder_.path(), .dual_fisheye = true});
  EXPECT_EQ(set.layout, FrameLayout::kDualFisheye);
  EXPECT_EQ(set.frame, (PanoramaSize{20, 20}));
}

TEST_F(CaptureSetTest, StationsOffTheirLineNeedATolerance) {
  folder_.write_cross();
  folder_.write_list(
      "a0.png,-0.1,0,0.5\na1.png,0,0,0.52\na2.png,0.1,0,0.5\n"
      "b0.png,0.3,0,-0.1\nb1.png,0.3,0,0\nb2.png,0.3,0,0.1\n");
  EXPECT_NE(error(), "no error");
  const CaptureSet set =
      read_capture_set({.directory = folder_.path(), .tolerance = {.off_line_m = 0.03}});
  EXPECT_EQ(set.lines.size(), 2U);
}

// gt.csv beside poses.csv: frames that are held out of the lines.
class HeldOutTest : public CaptureSetTest {
 protected:
  HeldOutTest() {
    folder_.write_cross();
    for (const char* file : {"gt/t0.png", "gt/t1.png", "gt/a0.png"}) folder_.add_picture(file);
  }
  void write_truth(const std::string& rows, const std::string& columns = "file,x,y,z") const {
    write_file_atomically(folder_ / "gt.csv", columns + "\n" + rows);
  }
};

TEST_F(HeldOutTest, FramesFollowTheStationsAndAreOnNoLine) {
  write_truth("gt/t0.png,0.05,0,0.05,3,0,0\ngt/t1.png,0,0,0,0,0,0\n", "file,x,y,z,yaw,pitch,roll");
  const CaptureSet set = folder_.read();
  EXPECT_EQ(set.stations(), 6U);
  EXPECT_THAT(names_of(set), ElementsAre("a0", "a1", "a2", "b0", "b1", "b2", "t0", "t1"));
  EXPECT_TRUE(set.frames[6].held_out());
  EXPECT_NEAR(set.frames[6].nominal_attitude->yaw_rad, radians_from_degrees(3.0), 1e-12);
  ASSERT_EQ(set.lines.size(), 2U);
  EXPECT_THAT(set.lines[0].frames, ElementsAre(0, 1, 2));
  EXPECT_THAT(set.lines[1].frames, ElementsAre(3, 4, 5));
  EXPECT_EQ(stations_only(set).frames.size(), 6U);
}

TEST_F(HeldOutTest, NameOfAStationIsNotTakenAgain) {
  write_truth("gt/t0.png,0,0,0\ngt/a0.png,0,0,0\n");
  const CaptureSet set = folder_.read();
  EXPECT_THAT(names_of(set), ElementsAre("a0", "a1", "a2", "b0", "b1", "b2", "gt_t0", "gt_a0"));
  EXPECT_TRUE(indices_by_name(set).contains("a0"));
  folder_.add_picture("a0.jpg");
  write_truth("a0.jpg,0,0,0\n");
  EXPECT_THAT(error(), AllOf(HasSubstr("gt.csv: "), HasSubstr("extension")));
}

TEST_F(HeldOutTest, StationIsNotHeldOutAtOnce) {
  for (const char* file : {"a1.png", "./a1.png", "gt/../a1.png"}) {
    write_truth(fmt::format("gt/t0.png,0,0,0\n{},0,0,0\n", file));
    EXPECT_THAT(error(), AllOf(HasSubstr("gt.csv:3: "), HasSubstr("a1.png"),
                               HasSubstr("poses.csv:3"), HasSubstr("held out")))
        << file;
  }
}

TEST_F(HeldOutTest, UnusableRowsAreNamed) {
  write_truth("gt/t0.png,nan,0,0\n");
  EXPECT_THAT(error(), AllOf(HasSubstr("gt.csv:2"), HasSubstr("x")));
  write_truth("gt/t0.png,0,0,2e6\n");
  EXPECT_THAT(error(), AllOf(HasSubstr("gt.csv:2"), HasSubstr("z = 2e+06")));
  write_truth("");
  EXPECT_THAT(error(), HasSubstr("gt.csv: lists no frames"));
  write_truth("gt/nowhere.png,0,0,0\n");
  EXPECT_THAT(error(), HasSubstr("nowhere.png"));
  folder_.add_picture("gt/t0.png", {32, 16});
  write_truth("gt/a0.png,0,0,0\ngt/t0.png,0,0,0\n");
  EXPECT_THAT(error(),
              AllOf(HasSubstr("gt.csv:3: "), HasSubstr("gt/t0.png is 32x16"), HasSubstr("16x8")));
  std::filesystem::remove(folder_ / "gt.csv");
  std::filesystem::create_symlink("nowhere.csv", folder_ / "gt.csv");
  EXPECT_THAT(error(), HasSubstr("gt.csv"));
}

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
    const std::vector<std::pair<std::string, double>> measured_mm{
        {"v0_001", 300.0}, {"x0_000", 190.0}, {"x0_001", 110.0}, {"v0_000", 100.0}};
    for (const std::string& lens : lenses) {
      for (const auto& [station, at_mm] : measured_mm) session_->add_frame(station, at_mm, lens);
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
  EXPECT_THAT(names_of(set), ElementsAre("x0_001", "x0_000", "v0_000", "v0_001"));
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

TEST_F(SessionFramesTest, MissingAndTruncatedFramesAreRefused) {
  write_session();
  std::filesystem::resize_file(folder_ / "frames/x0_001_both_0.png", 10);
  EXPECT_THAT(error(), AllOf(HasSubstr("x0_001_both_0.png"), HasSubstr("10 bytes")));
  std::filesystem::remove(folder_ / "frames/x0_001_both_0.png");
  EXPECT_THAT(error(true), AllOf(HasSubstr("x0_001_both_0.png"), HasSubstr("No such file"),
                                 HasSubstr("restore")));
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
