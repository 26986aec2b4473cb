// calibration.json and the page that shows it.
#include "calibrate/chain/calibration_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calibrate/base/test_capture_folder.h"
#include "calibrate/poses/poses_document.h"
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
    solved_.poses = nominal_poses(set);
    solved_.rails = fit_rails(set, solved_.poses);
    for (std::size_t line = 0; line < 2; ++line) {
      solved_.lines.push_back({.line = line, .stations = 3, .keyframes = 3});
    }
    solved_.crossings = {{.check = {.crossing = crossings_of(set).front(), .points = 20},
                          .correction_mm = 8.76,
                          .correction_deg = 0.5}};
    solved_.notes = {"a <note>"};
  }
  // After the steps mask, poses and rectify.
  std::unique_ptr<Calibration> calibrated() const {
    auto calibration = std::make_unique<Calibration>(options_);
    calibration->run(CalibrationStep::kMask);
    write_poses(calibration->out() / "poses.json", calibration->captured(), solved_);
    calibration->run(CalibrationStep::kRectify);
    return calibration;
  }
  ordered_json written() const {
    return ordered_json::parse(read_file(folder_ / "calibration/calibration.json"));
  }

  TestCaptureFolder folder_;
  CalibrationOptions options_;
  PosesResult solved_{};
};

TEST_F(CalibrationReportTest, HoldsTheDocumentsOfTheSteps) {
  const auto calibration = calibrated();
  const ordered_json trade{{{"keyframes_mm", 150.0}}};
  write_calibration(*calibration,
                    {{CalibrationStep::kMask, 2.5, true},
                     {CalibrationStep::kPoses, 1.0, false},
                     {CalibrationStep::kRectify, 56.5, false}},
                    trade);
  const ordered_json document = written();
  EXPECT_EQ(document["source"], folder_.path().string());
  EXPECT_EQ(document["stations"], 6);
  EXPECT_EQ(document["trustworthy"], true);
  EXPECT_EQ(document["notes"], ordered_json::array({"poses: a <note>"}));
  EXPECT_EQ(document["keyframe_trade"], trade);
  EXPECT_EQ(document["steps"][0]["seconds"], 2.5);
  EXPECT_EQ(document["steps"][0]["reused"], true);
  for (const char* step : {"mask", "poses", "rectify"}) {
    const std::filesystem::path file = calibration->out() / (std::string(step) + ".json");
    EXPECT_EQ(document[step], ordered_json::parse(read_file(file))) << step;
  }
  EXPECT_FALSE(document.contains("lens"));
  EXPECT_THAT(read_file(calibration->out() / "index.html"),
              AllOf(HasSubstr("\"kind\":\"calibration\""), HasSubstr("red: masked"),
                    HasSubstr("x0 × z0, frames a1 and b1"), HasSubstr("data:image/jpeg;base64,"),
                    HasSubstr("a \\u003cnote>")));
}

TEST_F(CalibrationReportTest, LaterStepsMayHaveOtherInputs) {
  const auto calibration = calibrated();
  write_calibration_until(*calibration, CalibrationStep::kMask);
  EXPECT_TRUE(written().contains("mask"));
  EXPECT_FALSE(written().contains("poses"));
  EXPECT_TRUE(written()["trustworthy"].is_null());
  EXPECT_THAT(read_file(calibration->out() / "index.html"), Not(HasSubstr("x0 × z0")));
}

TEST_F(CalibrationReportTest, WarningsNameTheirStep) {
  solved_.warnings = {"look & see"};
  write_calibration_until(*calibrated(), CalibrationStep::kRectify);
  EXPECT_EQ(written()["trustworthy"], false);
  EXPECT_EQ(written()["warnings"], ordered_json::array({"poses: look & see"}));
}

TEST_F(CalibrationReportTest, StepsSayWhatTheyAchieved) {
  const auto calibration = calibrated();
  const auto numbers = [&](CalibrationStep step) {
    return step_numbers(step, step_document(*calibration, step));
  };
  EXPECT_THAT(numbers(CalibrationStep::kMask), HasSubstr("% of the sphere is masked"));
  EXPECT_THAT(
      numbers(CalibrationStep::kPoses),
      HasSubstr("largest error at the 1 crossings 0.00 mm and 0.00 px (W = 4096), by 8.8 mm "
                "and 0.50 degrees corrected"));
  EXPECT_EQ(numbers(CalibrationStep::kRectify), "6 frames");
}

TEST_F(CalibrationReportTest, DamagedDocumentsAreNamed) {
  const auto calibration = calibrated();
  write_file_atomically(calibration->out() / "poses.json", std::string("{"));
  try {
    write_calibration_until(*calibration, CalibrationStep::kRectify);
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("poses.json: damaged"), HasSubstr("run the step again")));
  }
}

}  // namespace
}  // namespace raywalk::calibrate
