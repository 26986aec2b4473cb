// calibration.json and the page that shows it.
#include "calibrate/chain/calibration_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calibrate/base/test_capture_folder.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class CalibrationReportTest : public ::testing::Test {
 protected:
  CalibrationReportTest() {
    folder_.write_cross();
    options_.input.directory = folder_.path();
    options_.mask.cone_deg = 20.0;
    const CaptureSet set = folder_.read();
    grid_.poses = nominal_poses(set);
    for (int i = 0; i < 2; ++i) {
      grid_.lines.push_back(
          {.line = i, .id = set.lines[static_cast<std::size_t>(i)].id, .stations = 3});
    }
    grid_.crossings = {{.along_x = 0, .along_z = 1, .trustworthy = true}};
    grid_.crossings[0].before.rotation_px = 8.765;
    grid_.notes = {"a <note>"};
  }
  // After the steps mask, grid and rectify.
  std::unique_ptr<Calibration> calibrated() const {
    auto calibration = std::make_unique<Calibration>(options_);
    calibration->run(CalibrationStep::kMask);
    write_file_atomically(calibration->out() / "grid.json",
                          json_text(grid_document(calibration->captured(), grid_)));
    calibration->run(CalibrationStep::kRectify);
    return calibration;
  }
  ordered_json written() const {
    return ordered_json::parse(read_file(folder_ / "calibration/calibration.json"));
  }

  TestCaptureFolder folder_;
  CalibrationOptions options_;
  GridResult grid_{.trustworthy = true};
};

TEST_F(CalibrationReportTest, HoldsTheDocumentsOfTheSteps) {
  const auto calibration = calibrated();
  const ordered_json trade{{{"keyframes_mm", 150.0}}};
  write_calibration(*calibration,
                    {{CalibrationStep::kMask, 2.5, true},
                     {CalibrationStep::kGrid, 1.0, false},
                     {CalibrationStep::kRectify, 56.5, false}},
                    trade);
  const ordered_json document = written();
  EXPECT_EQ(document["source"], folder_.path().string());
  EXPECT_EQ(document["stations"], 6);
  EXPECT_EQ(document["trustworthy"], true);
  EXPECT_EQ(document["notes"], ordered_json::array({"grid: a <note>"}));
  EXPECT_EQ(document["keyframe_trade"], trade);
  EXPECT_EQ(document["steps"][0]["seconds"], 2.5);
  EXPECT_EQ(document["steps"][0]["reused"], true);
  for (const char* step : {"mask", "grid", "rectify"}) {
    const std::filesystem::path file = calibration->out() / (std::string(step) + ".json");
    EXPECT_EQ(document[step], ordered_json::parse(read_file(file))) << step;
  }
  EXPECT_FALSE(document.contains("poses"));
  EXPECT_THAT(read_file(calibration->out() / "index.html"),
              AllOf(HasSubstr("\"kind\":\"calibration\""), HasSubstr("red: masked"),
                    HasSubstr("x0 × z0, frames a1 and b1"), HasSubstr("data:image/jpeg;base64,"),
                    HasSubstr("a \\u003cnote>")));
}

TEST_F(CalibrationReportTest, LaterStepsMayHaveOtherInputs) {
  const auto calibration = calibrated();
  write_calibration_until(*calibration, CalibrationStep::kMask);
  EXPECT_TRUE(written().contains("mask"));
  EXPECT_FALSE(written().contains("grid"));
  EXPECT_TRUE(written()["trustworthy"].is_null());
  EXPECT_THAT(read_file(calibration->out() / "index.html"), Not(HasSubstr("x0 × z0")));
}

TEST_F(CalibrationReportTest, WarningsNameTheirStep) {
  grid_.trustworthy = false;
  grid_.warnings = {"look & see"};
  write_calibration_until(*calibrated(), CalibrationStep::kRectify);
  EXPECT_EQ(written()["trustworthy"], false);
  EXPECT_EQ(written()["warnings"], ordered_json::array({"grid: look & see"}));
}

TEST_F(CalibrationReportTest, StepsSayWhatTheyAchieved) {
  const auto calibration = calibrated();
  const auto numbers = [&](CalibrationStep step) {
    return step_numbers(step, step_document(*calibration, step));
  };
  EXPECT_THAT(numbers(CalibrationStep::kMask), HasSubstr("% of the sphere is masked"));
  EXPECT_EQ(numbers(CalibrationStep::kGrid),
            "6 stations on 2 lines, largest error at the 1 crossings 0.00 mm and 0.00 px (W = "
            "4096), before 0.00 mm and 8.77 px");
  EXPECT_EQ(numbers(CalibrationStep::kRectify), "6 frames");
}

TEST_F(CalibrationReportTest, DamagedDocumentsAreNamed) {
  const auto calibration = calibrated();
  write_file_atomically(calibration->out() / "grid.json", std::string("{"));
  try {
    write_calibration_until(*calibration, CalibrationStep::kRectify);
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("grid.json: damaged"), HasSubstr("run the step again")));
  }
}

}  // namespace
}  // namespace raywalk::calibrate
