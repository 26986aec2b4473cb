// The summary of a calibration and its page.
#include "calibrate/chain/calibration_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calibrate/base/test_capture_folder.h"
#include "calibrate/chain/calibration_summary.h"
#include "core/files/json_text.h"
#include "core/report/markup_check.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class CalibrationPageTest : public ::testing::Test {
 protected:
  CalibrationPageTest() {
    folder_.write_cross();
    options_.input.directory = folder_.path();
    options_.rectify.equalise_gain = false;
    const CaptureSet set = folder_.read();
    grid_.poses = nominal_poses(set);
    for (int i = 0; i < 2; ++i) {
      grid_.lines.push_back(
          {.line = i, .id = set.lines[static_cast<std::size_t>(i)].id, .stations = 3});
    }
    grid_.lines[1].roll_deg = {1.234, 0.056};
    grid_.lines[1].position_models = {{.name = "straight"}, {.name = "bowed", .kept = true}};
    grid_.crossings = {{.along_x = 0, .along_z = 1, .trustworthy = true}};
    grid_.crossings[0].before.rotation_px = 8.765;
    grid_.crossings[0].after.position_mm = 0.432;
  }
  // The page after the step rectify, with the given trade.
  std::string page(const std::vector<KeyframeTrial>& trade = {}) {
    const auto calibration = std::make_unique<Calibration>(options_);
    write_file_atomically(calibration->out() / "grid.json",
                          json_text(grid_document(calibration->captured(), grid_)));
    calibration->run(CalibrationStep::kRectify);
    CalibrationSummary summary = summary_of(*calibration);
    summary.steps = {{.step = CalibrationStep::kMask, .seconds = 2.34, .reused = true},
                     {.step = CalibrationStep::kRectify, .seconds = 56.78}};
    summary.trade = trade;
    write_calibration(*calibration, summary);
    std::string page = read_file(calibration->out() / "index.html");
    EXPECT_EQ(markup_fault(page), "");
    return page;
  }

  TestCaptureFolder folder_;
  CalibrationOptions options_;
  GridResult grid_{.trustworthy = true};
};

TEST_F(CalibrationPageTest, ShowsVerdictCrossingsLinesAndTheNextStep) {
  grid_.notes = {"a <note>"};
  const std::string page = this->page();
  EXPECT_THAT(page, AllOf(HasSubstr("Calibration of " + folder_.path().string()),
                          HasSubstr("6 stations on 2 lines, poses from COLMAP and the slider"),
                          HasSubstr("<dd>yes</dd>"), HasSubstr("8.77 → 0.00 px"),
                          HasSubstr("0.00 → 0.43 mm"), HasSubstr("grid: a &lt;note&gt;")));
  EXPECT_THAT(page, AllOf(HasSubstr("x0 × z0"), HasSubstr("1.234 ± 0.056"), HasSubstr("bowed"),
                          HasSubstr("differ by 0.00 levels RMS"),
                          HasSubstr("raywalk-build-lf pack --frames")));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("<h2>Warnings</h2>")), Not(HasSubstr("keyframes"))));
}

TEST_F(CalibrationPageTest, LinksTheStepsThatHaveAPage) {
  const std::string page = this->page();
  EXPECT_THAT(page, AllOf(HasSubstr("href=\"rectify.html\""), HasSubstr("56.8"),
                          HasSubstr("frames in world axes"), HasSubstr("2.3"),
                          HasSubstr("masks what moves"), Not(HasSubstr("href=\"mask.html\""))));
}

TEST_F(CalibrationPageTest, ShowsWarningsAndWhatFewerKeyframesGive) {
  grid_.method = options_.method = GridMethod::kRotation;
  grid_.trustworthy = false;
  grid_.warnings = {"look & see"};
  const std::string page = this->page({{.keyframes = 6, .seconds = 12.3, .trustworthy = true},
                                       {.keyframes_mm = 150.0,
                                        .keyframes = 4,
                                        .median_mm = 0.1234,
                                        .largest_mm = 0.5678,
                                        .median_deg = 0.01234,
                                        .largest_deg = 0.05678}});
  EXPECT_THAT(page, AllOf(HasSubstr("without solved poses"), HasSubstr("<dd>no</dd>"),
                          HasSubstr("<h2>Warnings</h2>"), HasSubstr("grid: look &amp; see")));
  EXPECT_THAT(page, AllOf(HasSubstr("0 mm"), HasSubstr("150 mm"), HasSubstr("0.123"),
                          HasSubstr("0.568"), HasSubstr("0.0123"), HasSubstr("0.0568")));
}

TEST_F(CalibrationPageTest, GridWithoutCrossingsHasNone) {
  grid_.crossings.clear();
  EXPECT_THAT(page(),
              AllOf(Not(HasSubstr("At the crossings")), Not(HasSubstr("largest rotation"))));
}

}  // namespace
}  // namespace raywalk::calibrate
