#include "capture/session/session_frames.h"

#include <gmock/gmock.h>

#include <fstream>

#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/test_directory.h"
#include "core/geometry/grid.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

namespace fs = std::filesystem;

class SessionExportTest : public testing::Test {
 protected:
  std::string write(const ExportOptions& options) {
    SessionReader reader(capture_.directory);
    return export_session(&reader, options);
  }
  std::string error(const ExportOptions& options) {
    return error_of([&] { write(options); });
  }
  CsvTable table(const std::string& name) {
    return CsvTable::read(capture_.directory / name, {"file", "x", "y", "z"}, {"line"});
  }

  TestDirectory directory_;
  TestCapture capture_{.directory = directory_ / "session", .plan = test_plan(true)};
};

TEST_F(SessionExportTest, ExportsAGridWithItsCellAndEveryStationOnce) {
  capture_.off_mm = 0.5;
  capture_.capture_missing(capture_.open().get());
  EXPECT_THAT(write({}),
              AllOf(HasSubstr("12 frames on 4 lines"), HasSubstr("3 ground-truth views")));
  const CsvTable poses = table("poses.csv");
  std::set<std::string> files;
  std::vector<StationPose> stations;
  for (std::size_t row = 0; row < poses.rows(); ++row) {
    EXPECT_TRUE(files.insert(poses.text(row, "file")).second);
    EXPECT_TRUE(fs::is_regular_file(capture_.directory / poses.text(row, "file")));
    stations.push_back({poses.text(row, "file"),
                        {poses.number(row, "x"), poses.number(row, "y"), poses.number(row, "z")},
                        "",
                        poses.text(row, "line")});
  }
  ASSERT_EQ(poses.rows(), 12U);
  EXPECT_EQ(stations[0].line, "x0");
  const Grid grid = find_grid(stations, {});
  EXPECT_EQ(grid.lines.size(), 4U);
  EXPECT_EQ(grid.cells.size(), 1U);
  EXPECT_NEAR(poses.number(0, "x"), -0.75 + 0.0005, 1e-9);
  EXPECT_NEAR(poses.number(0, "z"), -0.5, 1e-9);
}

TEST_F(SessionExportTest, ExportsValidationLinesAsGroundTruth) {
  capture_.capture_missing(capture_.open().get());
  write({});
  const CsvTable truth = table("gt.csv");
  ASSERT_EQ(truth.rows(), 3U);
  EXPECT_EQ(truth.text(0, "file"), "frames/v0_000.jpg");
  EXPECT_NEAR(truth.number(0, "x"), -0.25, 1e-9);
  EXPECT_EQ(truth.number(0, "z"), 0.0);
}

TEST_F(SessionExportTest, WritesNoGroundTruthWithoutValidationLines) {
  capture_.plan = test_plan();
  capture_.capture_missing(capture_.open().get());
  write({});
  EXPECT_FALSE(fs::exists(capture_.directory / "gt.csv"));
}

TEST_F(SessionExportTest, RefusesAnUnfinishedSessionAndSaysWhatIsMissing) {
  capture_.capture_missing(capture_.open().get(), 7);
  EXPECT_THAT(error({}),
              AllOf(HasSubstr("8 of 15 stations"), HasSubstr("z0_001"), HasSubstr("--partial")));
  EXPECT_FALSE(fs::exists(capture_.directory / "poses.csv"));
  write({.partial = true});
  EXPECT_EQ(table("poses.csv").rows(), 7U);
}

TEST_F(SessionExportTest, RefusesPicturesThatAreStillOnTheCard) {
  capture_.config.camera.kind = CameraKind::kGpio;
  capture_.capture_missing(capture_.open().get());
  EXPECT_THAT(error({}), HasSubstr("pictures of 15 not imported"));
  EXPECT_THAT(error({.partial = true}), HasSubstr("nothing to export"));
}

TEST_F(SessionExportTest, ChoosesAnExposureOfTheBracket) {
  capture_.config.camera.exposure.bracket_ev = {0.0, -2.0};
  capture_.capture_missing(capture_.open().get());
  write({.exposure = 1});
  EXPECT_EQ(table("poses.csv").rows(), 12U);
  EXPECT_EQ(table("poses.csv").text(0, "file"), "frames/x0_000_e1.jpg");
  write({.exposure = 0});
  EXPECT_EQ(table("poses.csv").text(0, "file"), "frames/x0_000.jpg");
}

TEST_F(SessionExportTest, RefusesAnExposureThatWasNotTaken) {
  capture_.config.camera.exposure.bracket_ev = {0.0, -2.0};
  capture_.capture_missing(capture_.open().get());
  EXPECT_THROW(write({.exposure = 2}), UsageError);
  EXPECT_THAT(error({.exposure = -1}), HasSubstr("--exposure takes 0 to 1"));
}

TEST_F(SessionExportTest, RefusesFisheyePicturesUnlessRequested) {
  capture_.config.camera.frames = FrameKind::kDualFisheye;
  capture_.capture_missing(capture_.open().get());
  EXPECT_THAT(error({}), AllOf(HasSubstr("raywalk-calibrate"), HasSubstr("--unstitched")));
  EXPECT_NO_THROW(write({.unstitched = true}));
}

TEST_F(SessionExportTest, ReplacesAnEarlierExportAndNothingElse) {
  capture_.capture_missing(capture_.open().get());
  const std::size_t frames = list_frames(capture_.directory).size();
  write({});
  const std::string first = read_file(capture_.directory / "poses.csv");
  EXPECT_THAT(first, StartsWith("file,x,y,z,line\n"));
  write({});
  EXPECT_EQ(read_file(capture_.directory / "poses.csv"), first);
  EXPECT_EQ(list_frames(capture_.directory).size(), frames);
}

}  // namespace
}  // namespace raywalk::capture
