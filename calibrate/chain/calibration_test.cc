// The steps of a capture, when a step counts as done, and errors for missing steps.
#include "calibrate/chain/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/base/test_capture_folder.h"
#include "core/base/error.h"

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
  // The message of the Error that `work` throws.
  template <typename Work>
  std::string error_of(const Work& work) const {
    try {
      Calibration calibration(options_);
      work(&calibration);
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }
  bool mask_is_done() const { return Calibration(options_).is_done(CalibrationStep::kMask); }

  TestCaptureFolder folder_;
  CalibrationOptions options_;
};

TEST_F(CalibrationTest, StepsDependOnTheCapture) {
  const Calibration panoramas(options_);
  EXPECT_FALSE(panoramas.has(CalibrationStep::kLens));
  EXPECT_FALSE(panoramas.has(CalibrationStep::kStitch));
  EXPECT_TRUE(panoramas.has(CalibrationStep::kPoses));
  EXPECT_EQ(panoramas.out(), folder_ / "calibration");
  CalibrationOptions other = options_;
  other.out = folder_ / "elsewhere";
  other.input.dual_fisheye = true;
  const Calibration fisheye(other);
  EXPECT_TRUE(fisheye.has(CalibrationStep::kStitch));
  EXPECT_TRUE(fisheye.has(CalibrationStep::kRectify));
}

TEST_F(CalibrationTest, StepIsDoneUntilItsInputsOrOptionsChange) {
  EXPECT_FALSE(mask_is_done());
  Calibration(options_).run(CalibrationStep::kMask);
  EXPECT_TRUE(mask_is_done());
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
  Calibration(options_).run(CalibrationStep::kMask);
  ASSERT_TRUE(mask_is_done());
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
    Calibration(options_).run(CalibrationStep::kMask);
    EXPECT_TRUE(mask_is_done()) << row;
  }
  write_own(5);
  EXPECT_FALSE(mask_is_done());
  Calibration(options_).run(CalibrationStep::kMask);
  std::filesystem::remove(folder_ / "gt.csv");
  EXPECT_FALSE(mask_is_done());
}

TEST_F(CalibrationTest, StepWithoutOutputsOrRecordIsNotDone) {
  Calibration(options_).run(CalibrationStep::kMask);
  std::filesystem::remove(folder_ / "calibration/mask.png");
  EXPECT_FALSE(mask_is_done());
  Calibration(options_).run(CalibrationStep::kMask);
  std::filesystem::remove(folder_ / "calibration/figures/mask.png");
  EXPECT_FALSE(mask_is_done());
  Calibration(options_).run(CalibrationStep::kMask);
  Calibration(options_).forget(CalibrationStep::kMask);
  EXPECT_FALSE(mask_is_done());
}

TEST_F(CalibrationTest, MaskOfAnEarlierRunIsRemoved) {
  Calibration(options_).run(CalibrationStep::kMask);
  options_.mask.cone_deg = 0.0;
  Calibration(options_).run(CalibrationStep::kMask);
  EXPECT_FALSE(Calibration(options_).mask());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "calibration/mask.json"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "calibration/figures/mask.png"));
}

TEST_F(CalibrationTest, MissingStepsAreNamed) {
  EXPECT_THAT(error_of([](Calibration* c) { c->run(CalibrationStep::kRectify); }),
              AllOf(HasSubstr("poses.json does not exist"), HasSubstr("raywalk-calibrate poses")));
  options_.input.dual_fisheye = true;
  EXPECT_THAT(error_of([](Calibration* c) { c->run(CalibrationStep::kMask); }),
              AllOf(HasSubstr("panoramas/"), HasSubstr("raywalk-calibrate stitch")));
  EXPECT_THAT(error_of([](Calibration* c) { c->run(CalibrationStep::kStitch); }),
              AllOf(HasSubstr("lens.yaml"), HasSubstr("raywalk-calibrate lens")));
  EXPECT_THROW(Calibration(options_).run(CalibrationStep::kLens), UsageError);
}

TEST_F(CalibrationTest, EveryStationNeedsAPose) {
  const CaptureSet set = folder_.read();
  FramePoses poses = nominal_poses(set);
  poses.front().reset();
  const auto final_poses = [](Calibration* c) { c->final_poses(); };
  std::filesystem::create_directories(folder_ / "calibration");
  const auto write = [&](const nlohmann::ordered_json& document) {
    write_file_atomically(folder_ / "calibration/poses.json", json_text(document));
  };
  write({{"format_version", 1}, {"frames", frame_poses_json(set, poses)}});
  EXPECT_THAT(error_of(final_poses),
              AllOf(HasSubstr("poses.json: frame '" + set.frames[0].name + "' has no pose"),
                    HasSubstr("run raywalk-calibrate poses again")));
  write_file_atomically(folder_ / "calibration/poses.json", std::string("{"));
  EXPECT_THAT(error_of(final_poses), AllOf(HasSubstr("poses.json"), HasSubstr("poses again")));
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
  EXPECT_THAT(error_of([](Calibration*) {}), HasSubstr("another raywalk-calibrate"));
}

TEST_F(CalibrationTest, UnreadableCaptureCreatesNoDirectory) {
  std::filesystem::remove(folder_ / "b1.png");
  EXPECT_NE(error_of([](Calibration*) {}), "no error");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "calibration"));
}

}  // namespace
}  // namespace raywalk::calibrate
