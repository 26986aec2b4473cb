// Frames rectified straight from fisheye pictures, against the ray-traced truth and against
// stitched panoramas that are rotated.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <utility>

#include "calibrate/base/frame_masks.h"
#include "calibrate/rectify/rectified_frames.h"
#include "calibrate/stitch/stitch_record.h"
#include "calibrate/stitch/stitch_set.h"
#include "calibrate/stitch/stitch_test_camera.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "core/panorama/panorama_rotation.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kFisheyeFrames = 3;

Attitude attitude_of(int frame) { return {0.3 + 0.4 * frame, 0.1 - 0.09 * frame, 0.05 * frame}; }

Eigen::Vector3d position_of(int frame) { return {0.06 * frame - 0.05, 0.0, 0.1}; }

// Without lens parallax, so that every difference from the truth is one of sampling.
const DualFisheyeCamera& fisheye_camera() {
  static const DualFisheyeCamera camera = test_camera(440, 0.0);
  return camera;
}

const std::vector<cv::Mat>& fisheye_pictures() {
  static const std::vector<cv::Mat> pictures = [] {
    const simulator::DualFisheyeRays rays(fisheye_camera().layout, fisheye_camera().picture);
    std::vector<cv::Mat> made;
    for (int i = 0; i < kFisheyeFrames; ++i) {
      made.push_back(test_room().render(rays, {position_of(i), attitude_of(i)}));
    }
    return made;
  }();
  return pictures;
}

class RectifiedFisheyeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    captured_ = fisheye_line(directory_.path(), fisheye_pictures());
    for (int i = 0; i < kFisheyeFrames; ++i) {
      captured_.frames[at(i)].nominal_m = position_of(i);
      poses_.emplace_back(FramePose{.position_m = position_of(i),
                                    .world_from_camera = world_from_camera(attitude_of(i)),
                                    .origin = PoseOrigin::kSolved});
    }
  }

  void stitch(int width) {
    panoramas_ = stitch_set(captured_, fisheye_camera(),
                            {.width = width, .balance = false, .out = directory_ / "out"});
    source_ = read_fisheye_source(captured_, fisheye_camera(), directory_ / "out");
  }

  // Rectifies into a directory of that name.
  void rectify(const std::string& name, const FramePoses& poses, const cv::Mat& mask = {}) const {
    make_directories(directory_ / name);
    write_rectified_frames(source_, panoramas_, poses, mask, directory_ / name);
  }
  cv::Mat mask_in(const std::string& name, int frame) const {
    return read_mask(directory_ / name / rectified_mask_file(captured_.frames[at(frame)]),
                     panoramas_.frame);
  }
  static std::size_t at(int frame) { return static_cast<std::size_t>(frame); }

  TestDirectory directory_;
  CaptureSet captured_{}, panoramas_{};
  FisheyeSource source_{};
  FramePoses poses_{};
};

TEST_F(RectifiedFisheyeTest, OneResamplingIsCloserToTheTruthThanTwo) {
  stitch(default_panorama_width(fisheye_camera()));
  rectify("once", poses_);
  double once_db = 0.0, twice_db = 0.0;
  for (std::size_t i = 0; i < kFisheyeFrames; ++i) {
    const FramePose& pose = *poses_[i];
    const cv::Mat truth =
        test_room().render(simulator::PanoramaRays(panoramas_.frame), {pose.position_m, {}});
    const cv::Mat once = read_panorama(directory_ / "once" / rectified_file(captured_.frames[i]));
    once_db += psnr_db(once, truth) / kFisheyeFrames;
    const cv::Mat stitched = read_panorama(panoramas_.frames[i].file);
    twice_db += psnr_db(rotate_panorama(stitched, pose.world_from_camera), truth) / kFisheyeFrames;
  }
  // Measured: 38.6 and 37.5 dB; a rotation wrong by 0.2 degrees would give 34.1.
  EXPECT_GT(once_db, twice_db + 0.7);
}

// A visitor before the front lens of one frame, the dolly below all.
TEST_F(RectifiedFisheyeTest, MasksAreTurnedWithTheirFrames) {
  cv::Mat own(fisheye_camera().picture.height, fisheye_camera().picture.width, CV_8UC1,
              cv::Scalar(255));
  const PixelPosition centre = fisheye_camera().layout.front.centre;
  cv::circle(own, {static_cast<int>(centre.u), static_cast<int>(centre.v)}, 20, cv::Scalar(0),
             cv::FILLED);
  write_image(directory_ / "own.png", own);
  captured_.frames[1].mask = directory_ / "own.png";
  stitch(512);
  poses_[1]->world_from_camera = world_from_camera({radians_from_degrees(30.0), 0.0, 0.0});
  cv::Mat dolly(panoramas_.frame.height, panoramas_.frame.width, CV_8UC1, cv::Scalar(255));
  dolly.rowRange(230, 256).setTo(0);
  rectify("once", poses_, dolly);
  const int right = 256 + 512 * 30 / 360;
  for (int frame = 0; frame < kFisheyeFrames; ++frame) {
    const cv::Mat mask = mask_in("once", frame);
    const bool visited = frame == 1;
    EXPECT_EQ(mask.at<uchar>(128, right), visited ? 0 : 255) << frame;
    EXPECT_EQ(mask.at<uchar>(128, right - 40), 255) << frame;
    EXPECT_EQ(mask.at<uchar>(255, 100), 0) << frame;
    // Only edges differ, where the mask of the panoramas was widened twice.
    const cv::Mat twice =
        rotate_mask(joint_mask(panoramas_, frame, dolly), poses_[at(frame)]->world_from_camera);
    const cv::Mat differs = mask != twice;
    EXPECT_LT(cv::countNonZero(differs), visited ? 0.2 * cv::countNonZero(mask == 0) : 1) << frame;
  }
  // Without the dolly only the visited frame has a mask.
  rectify("visited", poses_);
  EXPECT_TRUE(fs::exists(directory_ / "visited/rectified/masks/x0_1.png"));
  EXPECT_FALSE(fs::exists(directory_ / "visited/rectified/masks/x0_0.png"));
  own.setTo(0);
  own.at<uchar>(static_cast<int>(centre.v), static_cast<int>(centre.u)) = 255;
  write_image(directory_ / "own.png", own);
  EXPECT_THAT(error_of([&] { rectify("visited", poses_); }),
              HasSubstr("of what the mask of frame x0_1 leaves, nothing remains"));
}

// A frame that cannot be read stops the run; finished frames are kept only for the same inputs.
TEST_F(RectifiedFisheyeTest, FramesAreMadeAnewWhenTheirInputsChange) {
  stitch(256);
  const fs::path last = captured_.frames.back().file;
  const std::string whole = read_file(last);
  write_file_atomically(last, std::string("no picture"));
  const fs::path first = directory_ / "out/rectified.partial/x0_0.png";
  const auto made_at = [&] {
    EXPECT_THROW(rectify("out", poses_), Error);
    EXPECT_TRUE(fs::exists(first));
    return fs::last_write_time(first);
  };
  auto made = made_at();
  EXPECT_EQ(made_at(), made);
  const auto is_anew = [&] {
    const auto now = made_at();
    return std::exchange(made, now) != now;
  };
  source_.camera.layout.front.focal_px += 0.1;
  EXPECT_TRUE(is_anew()) << "the lens";
  source_.back_gain[1] = 1.01;
  EXPECT_TRUE(is_anew()) << "the balance of the lenses";
  source_.camera.falloff_2 = -0.01;
  EXPECT_TRUE(is_anew()) << "the falloff of the lenses";
  source_.options.blend_deg = 3.0;
  EXPECT_TRUE(is_anew()) << "the blend";
  write_image(captured_.frames[0].file, fisheye_pictures()[1]);
  EXPECT_TRUE(is_anew()) << "a picture";
  EXPECT_FALSE(is_anew());
  write_file_atomically(last, whole);
  rectify("out", poses_);
  EXPECT_TRUE(fs::exists(directory_ / "out/rectified/x0_0.png"));
}

TEST_F(RectifiedFisheyeTest, AMissingOrUnfinishedStitchIsNamed) {
  const auto message = [&] {
    return error_of([&] { read_fisheye_source(captured_, fisheye_camera(), directory_ / "out"); });
  };
  EXPECT_THAT(message(), HasSubstr("stitch.json: missing"));
  stitch(256);
  EXPECT_EQ(source_.width, 256);
  EXPECT_EQ(message(), "no error");
  std::string text = read_file(directory_ / "out/stitch.json");
  text.replace(text.find("\"complete\": true"), 16, "\"complete\": false");
  write_file_atomically(directory_ / "out/stitch.json", text);
  EXPECT_THAT(message(), HasSubstr("run raywalk-calibrate stitch"));
}

}  // namespace
}  // namespace raywalk::calibrate
