#include "calibrate/stitch/stitcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibrate/stitch/stitch_test_camera.h"
#include "core/base/test_error.h"
#include "core/panorama/panorama_rotation.h"
#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kWidth = 512;
constexpr PanoramaSize kSize{kWidth, kWidth / 2};
constexpr int kFrameHeight = 290;  // of frames whose own width is about 512
constexpr double kInfinity = std::numeric_limits<double>::infinity();

cv::Mat frame_of(const DualFisheyeCamera& camera) {
  return test_room().render(simulator::DualFisheyeRays(camera.layout, camera.picture), kTestPose);
}

const cv::Mat& truth() {
  static const cv::Mat panorama = test_room().render(simulator::PanoramaRays(kSize), kTestPose);
  return panorama;
}

// The PSNR of resampling alone: a panorama of the rotated camera, rotated back.
double resampling_psnr_db() {
  const Eigen::Matrix3d turned = world_from_camera({0.7, 0.4, -0.2});
  const Eigen::Matrix3d pose = world_from_camera(kTestPose.attitude);
  const simulator::CameraPose other{kTestPose.position_m,
                                    attitude_from_world_from_camera(pose * turned)};
  return psnr_db(rotate_panorama(test_room().render(simulator::PanoramaRays(kSize), other), turned),
                 truth());
}

DualFisheyeCamera grey_camera() { return test_camera(200, 0.0); }

// One level in the front lens's half of the picture, another in the back lens's.
cv::Mat two_levels(PanoramaSize picture, int front, int back) {
  cv::Mat frame(picture.height, picture.width, CV_8UC3, cv::Scalar::all(front));
  frame(cv::Rect(picture.width / 2, 0, picture.width / 2, picture.height)).setTo(back);
  return frame;
}

// The largest difference between neighbours of a row, the seams included.
int largest_step(const cv::Mat& panorama) {
  int largest = 0;
  for (int u = 1; u < panorama.cols; ++u) {
    const int row = panorama.rows / 2;
    largest = std::max(largest, std::abs(panorama.at<cv::Vec3b>(row, u)[1] -
                                         panorama.at<cv::Vec3b>(row, u - 1)[1]));
  }
  return largest;
}

TEST(StitcherTest, AgreesWithTheRoomAsWellAsResamplingAllows) {
  const DualFisheyeCamera camera = test_camera(kFrameHeight, 0.0);
  EXPECT_NEAR(default_panorama_width(camera), kWidth, 16);
  const cv::Mat frame = frame_of(camera), seam = near_seam(kSize, 4.0);
  const double resampling_db = resampling_psnr_db();
  for (const BlendMethod blend : {BlendMethod::kMultiBand, BlendMethod::kFeather}) {
    const cv::Mat panorama = Stitcher(camera, kWidth, {.blend = blend}).stitch(frame);
    const double off_seam_db = psnr_db(panorama, truth(), ~seam);
    // 36.8 of 37.4 dB: in the middle of the lenses the frame is a little coarser than a panorama.
    EXPECT_GT(off_seam_db, resampling_db - 1.0);
    // There the fisheye pictures are finer than the panorama.
    EXPECT_GT(psnr_db(panorama, truth(), seam), off_seam_db);
  }
}

// Lenses 10 mm apart image near objects at different places. A seam distance at the room's typical
// distance corrects most of that.
TEST(StitcherTest, SeamDistanceReducesParallaxErrors) {
  const DualFisheyeCamera camera = test_camera(kFrameHeight, 0.01);
  const cv::Mat frame = frame_of(camera), seam = near_seam(kSize, 4.0);
  const cv::Mat far = Stitcher(camera, kWidth, {.seam_distance_m = kInfinity}).stitch(frame);
  const cv::Mat near = Stitcher(camera, kWidth, {.seam_distance_m = 1.5}).stitch(frame);
  EXPECT_GT(psnr_db(near, truth(), seam), psnr_db(far, truth(), seam) + 1.5);
  EXPECT_GT(psnr_db(near, truth()), psnr_db(far, truth()) + 0.5);
  EXPECT_GT(psnr_db(far, truth(), seam), 30.0);
}

// At half the width edges stay smooth, as all of the frame's pixels are averaged.
TEST(StitcherTest, CoarsePanoramaIsAveragedDown) {
  const DualFisheyeCamera camera = test_camera(kFrameHeight, 0.0);
  const cv::Mat frame = frame_of(camera);
  const cv::Mat coarse = Stitcher(camera, kWidth / 4, {}).stitch(frame);
  cv::Mat averaged;
  cv::resize(truth(), averaged, coarse.size(), 0, 0, cv::INTER_AREA);
  EXPECT_GT(psnr_db(coarse, averaged), 40.0);
}

// What one lens hides is taken from the other where both are blended, and masked elsewhere; nothing
// of it reaches other pixels.
TEST(StitcherTest, MaskedPixelsAreReplacedAlongTheSeamAndMaskedElsewhere) {
  const DualFisheyeCamera camera = test_camera(kFrameHeight, 0.0);
  const cv::Mat frame = frame_of(camera);
  cv::Mat mask(frame.size(), CV_8UC1, cv::Scalar(255)), spoilt = frame.clone();
  // From the rim of the front lens, to the right, towards its middle.
  const cv::Rect hidden(200, 120, 90, 40);
  mask(hidden).setTo(0);
  spoilt(hidden).setTo(cv::Scalar(255, 0, 255));
  for (const BlendMethod blend : {BlendMethod::kMultiBand, BlendMethod::kFeather}) {
    const Stitcher stitcher(camera, kWidth, {.blend = blend, .blend_deg = 4.0});
    const StitchedFrame stitched = stitcher.stitch(spoilt, spoilt, mask);
    ASSERT_EQ(stitched.mask.size(), stitched.panorama.size());
    const int masked = cv::countNonZero(stitched.mask == 0);
    EXPECT_GT(masked, 1000);
    EXPECT_LT(masked, 8000);
    // Ahead to the right, and behind the seam at 90 degrees.
    EXPECT_EQ(stitched.mask.at<uchar>(128, 256 + 128 * 80 / 90), 0);
    EXPECT_EQ(stitched.mask.at<uchar>(128, 256 + 128 * 91 / 90), 255);
    EXPECT_GT(psnr_db(stitched.panorama, truth(), stitched.mask), 33.0);
    const StitchedFrame whole = stitcher.stitch(frame, frame, cv::Mat());
    EXPECT_TRUE(whole.mask.empty());
    // In the blended band there are as many pixels that both lenses would have shown.
    cv::Mat changed;
    cv::absdiff(whole.panorama, stitched.panorama, changed);
    cv::cvtColor(changed, changed, cv::COLOR_BGR2GRAY);
    EXPECT_EQ(cv::countNonZero((changed > 60) & stitched.mask), 0);
  }
  // Coarser than the frame: a pixel of which a part is masked is masked.
  const Stitcher coarse(camera, kWidth / 4, {});
  const StitchedFrame reduced = coarse.stitch(spoilt, spoilt, mask);
  EXPECT_EQ(reduced.mask.size(), cv::Size(kWidth / 4, kWidth / 8));
  cv::Mat averaged;
  cv::resize(truth(), averaged, reduced.panorama.size(), 0, 0, cv::INTER_AREA);
  EXPECT_GT(psnr_db(reduced.panorama, averaged, reduced.mask), 36.0);
}

TEST(StitcherTest, FalloffIsCorrectedAsTheLensFileGivesIt) {
  DualFisheyeCamera camera = grey_camera();
  camera.falloff_2 = -0.2;
  const cv::Mat brightened = Stitcher(camera, 256, {}).stitch(two_levels(camera.picture, 100, 100));
  EXPECT_NEAR(brightened.at<cv::Vec3b>(64, 128)[1], 100, 1);
  // At 90 degrees e^(0.2 * 2.467) = 1.638 times the light: level 126.
  EXPECT_NEAR(brightened.at<cv::Vec3b>(64, 192)[1], 126, 1);
}

// Dark levels lie on sRGB's straight toe, for which the correction is an approximation.
TEST(StitcherTest, GainFollowsTheTransferCurve) {
  const DualFisheyeCamera camera = grey_camera();
  for (const double factor : {0.7, 0.95, 1.1, 1.6}) {
    const Stitcher stitcher(camera, 128, {}, {1 / factor, 1 / factor, 1 / factor});
    for (int level = 0; level <= 255; level += level < 20 ? 1 : 20) {
      const double truth =
          std::min(srgb_level_from_linear(factor * linear_from_srgb_level(level)), 255.0);
      const cv::Mat panorama = stitcher.stitch(two_levels(camera.picture, 90, level));
      // Half a level is the rounding of the panorama.
      EXPECT_NEAR(panorama.at<cv::Vec3b>(32, 0)[1], truth,
                  std::min<double>(level, truth) < 11 ? 1.3 : 0.55)
          << factor << " " << level;
    }
  }
}

TEST(StitcherTest, BlendsHideAStepOfBrightness) {
  const DualFisheyeCamera camera = grey_camera();
  const cv::Mat frame = two_levels(camera.picture, 100, 140);
  const auto step = [&](BlendMethod blend, double blend_deg) {
    const StitcherOptions options{.blend = blend, .blend_deg = blend_deg};
    return largest_step(Stitcher(camera, 512, options).stitch(frame));
  };
  EXPECT_EQ(step(BlendMethod::kFeather, 1e-3), 40);
  EXPECT_LT(step(BlendMethod::kFeather, 6.0), 8);
  EXPECT_LT(step(BlendMethod::kMultiBand, 6.0), 12);
  EXPECT_LT(step(BlendMethod::kMultiBand, kDefaultBlend_deg), 30);
}

TEST(StitcherTest, UniformFramesStayUniformEverywhere) {
  const DualFisheyeCamera camera = grey_camera();
  for (const BlendMethod blend : {BlendMethod::kMultiBand, BlendMethod::kFeather}) {
    const cv::Mat panorama = Stitcher(camera, 512, {.blend = blend, .blend_deg = 5.0})
                                 .stitch(two_levels(camera.picture, 77, 77));
    EXPECT_EQ(
        cv::norm(panorama, cv::Mat(panorama.size(), CV_8UC3, cv::Scalar::all(77)), cv::NORM_INF),
        0.0);
  }
}

TEST(StitcherTest, GapBetweenTheLensesIsAnError) {
  DualFisheyeCamera camera = grey_camera();
  camera.layout.back.largest_angle_rad = radians_from_degrees(85.0);
  camera.layout.front.largest_angle_rad = radians_from_degrees(92.0);
  EXPECT_THAT(error_of([&] { Stitcher(camera, 256, {}); }),
              AllOf(HasSubstr("leave a gap of"), HasSubstr("largest_angle_deg")));
}

TEST(StitcherTest, SeamOfUnequalLensesIsWhereBothReach) {
  DualFisheyeCamera camera = grey_camera();
  camera.layout.back.largest_angle_rad = radians_from_degrees(86.0);
  const cv::Mat panorama = Stitcher(camera, 512, {}).stitch(two_levels(camera.picture, 50, 200));
  // The seam lies 5.5 degrees behind the plane between the lenses.
  EXPECT_EQ(panorama.at<cv::Vec3b>(128, 256 + 128 + 2)[0], 50);
  EXPECT_EQ(panorama.at<cv::Vec3b>(128, 256 + 128 + 14)[0], 200);
}

TEST(StitcherTest, OptionsOutOfRangeAreUsageErrors) {
  const DualFisheyeCamera camera = grey_camera();
  for (const int width : {0, 62, 513, 40000, -2}) {
    EXPECT_THROW(Stitcher(camera, width, {}), UsageError) << width;
  }
  for (const double blend_deg : {0.0, -1.0, 31.0, std::nan("")}) {
    EXPECT_THROW(Stitcher(camera, 256, {.blend_deg = blend_deg}), UsageError) << blend_deg;
  }
  for (const double distance_m : {0.0, -1.0, std::nan("")}) {
    EXPECT_THROW(Stitcher(camera, 256, {.seam_distance_m = distance_m}), UsageError);
  }
}

}  // namespace
}  // namespace raywalk::calibrate
