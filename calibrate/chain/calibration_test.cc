// The steps of a capture, when a step counts as done, errors for missing steps; calibration.json
// and the page that shows it.
#include "calibrate/chain/calibration.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "calibrate/base/test_capture_folder.h"
#include "calibrate/chain/calibration_report.h"
#include "calibrate/poses/poses_document.h"
#include "core/files/json.h"
#include "core/files/test_json.h"
#include "core/files/test_support.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class CalibrationTest : public ::testing::Test {
 protected:
  CalibrationTest() {
    folder_.write_cross();
    options_.input.directory = folder_.path();
    options_.mask.cone_deg = 20.0;
  }
  std::string error_of_step(CalibrationStep step) const {
    return error_of([&] { Calibration(options_).run(step); });
  }
  bool mask_is_done() const { return Calibration(options_).is_done(CalibrationStep::kMask); }
  void make_mask() const {
    Calibration(options_).run(CalibrationStep::kMask);
    EXPECT_TRUE(mask_is_done());
  }

  TestCaptureFolder folder_;
  CalibrationOptions options_;
};

TEST_F(CalibrationTest, StepIsDoneUntilItsInputsOrOptionsChange) {
  EXPECT_FALSE(mask_is_done());
  make_mask();
  ASSERT_TRUE(Calibration(options_).mask());
  // Options of other steps do not matter.
  options_.poses.keyframes_mm = 100.0;
  EXPECT_TRUE(mask_is_done());
  options_.mask.cone_deg = 21.0;
  EXPECT_FALSE(mask_is_done());
  options_.mask.cone_deg = 20.0;
  EXPECT_TRUE(mask_is_done());
  // A frame that was captured again.
  folder_.add_picture("a1.png");
  write_image(folder_ / "a1.png", cv::Mat(8, 16, CV_8UC3, cv::Scalar(1, 2, 3)));
  EXPECT_FALSE(mask_is_done());
}

TEST_F(CalibrationTest, MasksAndHeldOutFramesAreInputs) {
  make_mask();
  folder_.add_picture("t.png");
  const auto hold_out = [&](const std::string& row) {
    write_file_atomically(folder_ / "gt.csv", "file,x,y,z,mask\n" + row + "\n");
  };
  const auto write_own = [&](int valid_rows) {
    cv::Mat own(8, 16, CV_8UC1, cv::Scalar(0));
    own.rowRange(0, valid_rows).setTo(255);
    write_image(folder_ / "own.png", own);
  };
  write_own(4);
  for (const char* row : {"t.png,0,0,0,", "t.png,0.01,0,0,", "t.png,0.01,0,0,own.png"}) {
    hold_out(row);
    EXPECT_FALSE(mask_is_done()) << row;
    make_mask();
  }
  write_own(5);
  EXPECT_FALSE(mask_is_done());
  make_mask();
  std::filesystem::remove(folder_ / "gt.csv");
  EXPECT_FALSE(mask_is_done());
}

TEST_F(CalibrationTest, StepWithoutItsOutputsOrRecordIsNotDone) {
  make_mask();
  const std::string mask = read_file(folder_ / "calibration/mask.png");
  write_image(folder_ / "calibration/mask.png", cv::Mat(8, 16, CV_8UC1, cv::Scalar(0)));
  EXPECT_FALSE(mask_is_done());
  write_file_atomically(folder_ / "calibration/mask.png", mask);
  EXPECT_TRUE(mask_is_done());  // compared by content
  std::filesystem::remove(folder_ / "calibration/figures/mask.png");
  EXPECT_FALSE(mask_is_done());
  make_mask();
  Calibration(options_).forget(CalibrationStep::kMask);
  EXPECT_FALSE(mask_is_done());
  make_mask();
  for (const char* bad :
       {"", "{", "[]", R"({"format_version": 2, "steps": {}})",
        R"({"format_version": 4294967297, "steps": {}})", R"({"format_version": 1.5, "steps": {}})",
        R"({"format_version": 1, "steps": {"mask": 3}})"}) {
    write_file_atomically(folder_ / "calibration/steps.json", std::string(bad));
    EXPECT_FALSE(mask_is_done()) << bad;
  }
}

TEST(StepRecords, OfLargeOutputsHaveTheirSizes) {
  const TestDirectory out;
  const auto is_done = [&] { return StepRecords(out.path()).done("poses", "abc").has_value(); };
  const auto write = [&](std::size_t bytes) {
    write_file_atomically(out / "big.bin", std::string(bytes, 'x'));
  };
  StepRecords records(out.path());
  EXPECT_THROW(records.note("poses", "abc", 1.5, {"big.bin"}), Error);
  EXPECT_FALSE(is_done());
  write((std::size_t{1} << 20) + 1);
  records.note("poses", "abc", 1.5, {"big.bin"});
  EXPECT_TRUE(is_done());
  EXPECT_EQ(StepRecords(out.path()).last("poses")->seconds, 1.5);
  write((std::size_t{1} << 20) + 2);
  EXPECT_FALSE(is_done());
}

TEST_F(CalibrationTest, MissingStepsAreNamed) {
  EXPECT_THAT(error_of_step(CalibrationStep::kRectify),
              AllOf(HasSubstr("poses.json does not exist"), HasSubstr("raywalk-calibrate poses")));
  options_.input.dual_fisheye = true;
  EXPECT_THAT(error_of_step(CalibrationStep::kMask),
              AllOf(HasSubstr("panoramas/"), HasSubstr("raywalk-calibrate stitch")));
  EXPECT_THAT(error_of_step(CalibrationStep::kStitch),
              AllOf(HasSubstr("lens.yaml"), HasSubstr("raywalk-calibrate lens")));
  EXPECT_THROW(Calibration(options_).run(CalibrationStep::kLens), UsageError);
}

TEST_F(CalibrationTest, EveryStationNeedsAPose) {
  const CaptureSet set = folder_.read();
  FramePoses poses = nominal_poses(set);
  poses.front().reset();
  std::filesystem::create_directories(folder_ / "calibration");
  const nlohmann::ordered_json document{{"format_version", 1},
                                        {"frames", frame_poses_json(set, poses)}};
  write_file_atomically(folder_ / "calibration/poses.json", json_text(document));
  EXPECT_THAT(error_of([&] { Calibration(options_).final_poses(); }),
              AllOf(HasSubstr("poses.json: frame '" + set.frames[0].name + "' has no pose"),
                    HasSubstr("run raywalk-calibrate poses again")));
}

TEST_F(CalibrationTest, GivenLensesReplaceTheFit) {
  options_.input.dual_fisheye = true;
  const DualFisheyeCamera camera{{64, 32}, false, simple_dual_fisheye({64, 32})};
  write_lens_file(folder_ / "given.yaml", camera);
  options_.lens_file = folder_ / "given.yaml";
  Calibration(options_).run(CalibrationStep::kLens);
  const auto taken = Calibration(options_).camera();
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->picture, (PanoramaSize{16, 8}));  // in the size of the frames
  EXPECT_NEAR(taken->layout.front.focal_px, camera.layout.front.focal_px / 4.0, 1e-9);
  EXPECT_TRUE(Calibration(options_).is_done(CalibrationStep::kLens));
  DualFisheyeCamera other = camera;
  other.layout.front.focal_px *= 1.01;
  write_lens_file(folder_ / "given.yaml", other);
  EXPECT_FALSE(Calibration(options_).is_done(CalibrationStep::kLens));
}

TEST_F(CalibrationTest, DirectoryIsLockedAgainstASecondProcess) {
  const Calibration first(options_);
  EXPECT_THAT(error_of([&] { const Calibration second(options_); }),
              HasSubstr("another raywalk-calibrate"));
}

class CalibrationReportTest : public CalibrationTest {
 protected:
  CalibrationReportTest() {
    const CaptureSet set = folder_.read();
    solved_.poses = nominal_poses(set);
    solved_.rails = fit_rails(set, solved_.poses);
    for (std::size_t line = 0; line < 2; ++line) {
      solved_.lines.push_back({.line = line, .stations = 3, .keyframes = 3});
    }
    solved_.intersections = {
        {.check = {.intersection = intersections_of(set).front(), .points = 20},
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
  nlohmann::ordered_json written() const {
    return nlohmann::ordered_json::parse(read_file(folder_ / "calibration/calibration.json"));
  }

  PosesResult solved_{};
};

TEST_F(CalibrationReportTest, HoldsTheDocumentsOfTheSteps) {
  const auto calibration = calibrated();
  const nlohmann::ordered_json trade{{{"keyframes_mm", 150.0}}};
  write_calibration(*calibration,
                    {{CalibrationStep::kMask, 2.5, true},
                     {CalibrationStep::kPoses, 1.0, false},
                     {CalibrationStep::kRectify, 56.5, false}},
                    trade);
  const nlohmann::json document = written();
  expect_keys(document, {{"source", folder_.path().string()},
                         {"stations", 6},
                         {"trustworthy", true},
                         {"notes", nlohmann::json::array({"poses: a <note>"})},
                         {"keyframe_trade", trade}});
  expect_keys(document["steps"][0], {{"seconds", 2.5}, {"reused", true}});
  for (const char* step : {"mask", "poses", "rectify"}) {
    const std::filesystem::path file = calibration->out() / (std::string(step) + ".json");
    EXPECT_EQ(document[step], nlohmann::json::parse(read_file(file))) << step;
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
  EXPECT_THAT(read_file(calibration->out() / "index.html"), ::testing::Not(HasSubstr("x0 × z0")));
}

TEST_F(CalibrationReportTest, WarningsNameTheirStep) {
  solved_.warnings = {"look & see"};
  write_calibration_until(*calibrated(), CalibrationStep::kRectify);
  EXPECT_EQ(written()["trustworthy"], false);
  EXPECT_EQ(written()["warnings"], nlohmann::ordered_json::array({"poses: look & see"}));
}

TEST_F(CalibrationReportTest, DamagedDocumentsAreNamed) {
  const auto calibration = calibrated();
  write_file_atomically(calibration->out() / "poses.json", std::string("{"));
  EXPECT_THAT(error_of([&] { write_calibration_until(*calibration, CalibrationStep::kRectify); }),
              AllOf(HasSubstr("poses.json: damaged"), HasSubstr("run the step again")));
}

}  // namespace
}  // namespace raywalk::calibrate
