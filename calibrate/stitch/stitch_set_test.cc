#include "calibrate/stitch/stitch_set.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <span>

#include "calibrate/stitch/stitch_record.h"
#include "calibrate/stitch/stitch_test_camera.h"
#include "calibrate/stitch/stitcher.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_json.h"
#include "core/files/test_support.h"
#include "core/panorama/panorama_rotation.h"
#include "core/panorama/srgb.h"
#include "simulator/room/sensor.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
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

cv::Mat truth_averaged_down() {
  cv::Mat averaged;
  cv::resize(truth(), averaged, {kWidth / 4, kWidth / 8}, 0, 0, cv::INTER_AREA);
  return averaged;
}

// At half the width edges stay smooth, as all of the frame's pixels are averaged.
TEST(StitcherTest, CoarsePanoramaIsAveragedDown) {
  const DualFisheyeCamera camera = test_camera(kFrameHeight, 0.0);
  const cv::Mat coarse = Stitcher(camera, kWidth / 4, {}).stitch(frame_of(camera));
  EXPECT_GT(psnr_db(coarse, truth_averaged_down()), 40.0);
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
  const StitchedFrame reduced = Stitcher(camera, kWidth / 4, {}).stitch(spoilt, spoilt, mask);
  EXPECT_EQ(reduced.mask.size(), cv::Size(kWidth / 4, kWidth / 8));
  EXPECT_GT(psnr_db(reduced.panorama, truth_averaged_down(), reduced.mask), 36.0);
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
              testing::AllOf(HasSubstr("leave a gap of"), HasSubstr("largest_angle_deg")));
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

// --- The frames of a capture ---------------------------------------------------------------------

constexpr int kStations = 12;
constexpr simulator::LensLightSettings kLight{.vignetting = 0.25, .lens_gain_ev = 0.2};

// A line of stations 25 mm apart, with vignetting lenses and sensor noise. Rendered once for all
// tests.
const std::vector<cv::Mat>& line_frames() {
  static const std::vector<cv::Mat> frames = [] {
    const DualFisheyeCamera camera = test_camera(220, 0.01);
    const cv::Mat light = lens_light(camera.layout, camera.picture, kLight);
    const simulator::SensorSettings sensor{.noise_levels = 1.0, .shot_noise = 0.02};
    std::vector<cv::Mat> made;
    for (int i = 0; i < kStations; ++i) {
      const simulator::CameraPose pose{{0.025 * i - 0.15, 0.0, 0.1}, {}};
      const cv::Mat seen =
          test_room().render(simulator::DualFisheyeRays(camera.layout, camera.picture), pose);
      made.push_back(apply_sensor(seen, sensor, 0.8 + 0.01 * i, static_cast<unsigned>(i), light));
    }
    return made;
  }();
  return frames;
}

class StitchSetTest : public testing::Test {
 protected:
  // The first `count` stations.
  CaptureSet line(std::size_t count) const {
    return fisheye_line(directory_.path(), std::span(line_frames()).first(count));
  }

  // The same with a file for each lens, and the camera's lens file for them.
  CaptureSet in_halves(std::size_t count) {
    CaptureSet set = line(count);
    const int half = camera_.picture.width / 2;
    camera_.picture.width = set.frame.width = half;
    camera_.two_files = true;
    camera_.layout.back.centre.u -= half;
    for (CaptureFrame& frame : set.frames) {
      const cv::Mat both = read_picture(frame.file);
      frame.back = directory_ / (frame.name + "_back.png");
      write_image(*frame.back, both(cv::Rect(half, 0, half, both.rows)));
      write_image(frame.file, both(cv::Rect(0, 0, half, both.rows)));
    }
    return set;
  }

  StitchOptions options() const { return {.width = 256, .out = directory_ / "out"}; }

  std::string message_of(const CaptureSet& set, const std::optional<DualFisheyeCamera>& camera) {
    return error_of([&] { stitch_set(set, camera, options()); });
  }

  fs::path panorama(int station) const {
    return directory_ / ("out/panoramas/x0_" + std::to_string(station) + ".png");
  }

  fs::path record_file() const { return directory_ / "out/stitch.json"; }
  nlohmann::json record() const { return nlohmann::json::parse(read_file(record_file())); }

  TestDirectory directory_;
  DualFisheyeCamera camera_ = test_camera(220, 0.01);
};

// Dark glass is before a part of the front lens's rim at all stations; the masks say so.
TEST_F(StitchSetTest, MasksGoWithTheirFramesAndCountNotInTheBalance) {
  CaptureSet set = line(6);
  cv::Mat mask(camera_.picture.height, camera_.picture.width, CV_8UC1, cv::Scalar(255));
  const PixelPosition centre = camera_.layout.front.centre;
  for (const auto [u, v] : pixels_of(camera_.picture)) {
    if (u < centre.u && std::hypot(u - centre.u, v - centre.v) > 80.0) mask.at<uchar>(v, u) = 0;
  }
  for (CaptureFrame& frame : set.frames) {
    cv::Mat picture = read_picture(frame.file);
    const cv::Mat dark = 0.5 * picture;
    dark.copyTo(picture, mask == 0);
    write_image(frame.file, picture);
  }
  const auto back_gain = [&] {
    stitch_set(set, camera_, options());
    return read_stitch_record(record_file())->back_gain[1];
  };
  EXPECT_GT(std::abs(back_gain() - std::exp2(0.2)), 0.05);
  EXPECT_FALSE(fs::exists(directory_ / "out/panoramas/masks"));
  write_image(directory_ / "mask.png", mask);
  for (CaptureFrame& frame : set.frames) frame.mask = directory_ / "mask.png";
  EXPECT_NEAR(back_gain(), std::exp2(0.2), 0.03);
  const CaptureSet stitched = stitch_set(set, camera_, options());
  ASSERT_EQ(stitched.frames[2].mask, directory_ / "out/panoramas/masks/x0_2.png");
  const cv::Mat warped = read_mask(*stitched.frames[2].mask, stitched.frame);
  EXPECT_EQ(warped.at<uchar>(64, 128 - 60), 0);    // to the left
  EXPECT_EQ(warped.at<uchar>(64, 128 + 60), 255);  // to the right
  EXPECT_EQ(warped.at<uchar>(64, 10), 255);        // behind
}

TEST_F(StitchSetTest, WritesPanoramasAndFigures) {
  CaptureSet panoramas = line(2);
  panoramas.layout = FrameLayout::kPanorama;  // is returned unchanged
  const CaptureSet same = stitch_set(panoramas, std::nullopt, options());
  EXPECT_EQ(same.frames[1].file, panoramas.frames[1].file);
  EXPECT_FALSE(fs::exists(directory_ / "out"));
  const CaptureSet set = stitch_set(line(3), camera_, options());
  EXPECT_EQ(set.layout, FrameLayout::kPanorama);
  EXPECT_EQ(set.frame, (PanoramaSize{256, 128}));
  ASSERT_EQ(set.frames.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(set.frames[i].file, panorama(i));
    EXPECT_EQ(read_panorama(panorama(i)).size(), cv::Size(256, 128));
  }
  EXPECT_EQ(blend_method_named("feather"), BlendMethod::kFeather);
  EXPECT_THROW(blend_method_named("none"), UsageError);
  const nlohmann::json json = record();
  expect_keys(
      json,
      {{"complete", true}, {"frames", 3}, {"blend", "multi-band"}, {"seam_distance_m", nullptr}});
  EXPECT_EQ(json.at("balance").at("frames"), 3);
  EXPECT_GT(json.at("balance").at("points"), 200);
  EXPECT_TRUE(json.at("warnings").empty());
  ASSERT_EQ(json.at("figures").size(), 5U);
  EXPECT_EQ(json.at("figures")[0].at("row"), "Station x0_1");
  EXPECT_EQ(json.at("figures")[3].at("row"), "Seam at 90 degrees");
  EXPECT_EQ(json.at("figures")[3].at("caption"), "as captured");
  for (const auto& figure : json.at("figures")) {
    EXPECT_FALSE(read_picture(directory_ / "out" / figure.at("file")).empty());
  }
}

// The lenses have vignetting, which no lens file gives, or gives too strongly.
TEST_F(StitchSetTest, GainHidesTheSeamWhateverTheFalloff) {
  for (const double falloff_2 : {0.0, -0.15}) {
    camera_.falloff_2 = falloff_2;
    stitch_set(line(kStations), camera_, options());
    const auto read = read_stitch_record(record_file());
    ASSERT_TRUE(read);
    for (const double gain : read->back_gain) {
      EXPECT_NEAR(gain, std::exp2(0.2), 0.015) << falloff_2;
    }
    const nlohmann::json seam = record().at("seam");
    EXPECT_GT(seam.at("step_before_levels"), 5.0);
    EXPECT_LT(seam.at("step_after_levels"), 0.5) << falloff_2;
    EXPECT_GT(seam.at("correlation"), 0.95) << falloff_2;
    EXPECT_TRUE(record().at("warnings").empty());
  }
}

TEST_F(StitchSetTest, ResumesAnInterruptedRun) {
  const CaptureSet set = line(3);
  stitch_set(set, camera_, options());
  const std::string first = read_file(panorama(1));
  // One is missing, another is marked: only the missing one is stitched again.
  fs::remove(panorama(1));
  const cv::Mat marked(128, 256, CV_8UC3, cv::Scalar(1, 2, 3));
  write_image(panorama(2), marked);
  stitch_set(set, camera_, options());
  EXPECT_EQ(read_file(panorama(1)), first);
  EXPECT_EQ(cv::norm(read_panorama(panorama(2)), marked, cv::NORM_INF), 0.0);
  // Also a figure that is missing is made.
  fs::remove(directory_ / "out/figures/stitch_right.png");
  stitch_set(set, camera_, options());
  EXPECT_TRUE(fs::exists(directory_ / "out/figures/stitch_right.png"));
  // With another camera all are stitched again.
  camera_.layout.front.focal_px += 0.5;
  stitch_set(set, camera_, options());
  EXPECT_GT(cv::norm(read_panorama(panorama(2)), marked, cv::NORM_INF), 50.0);
  EXPECT_NE(read_file(panorama(1)), first);
}

TEST_F(StitchSetTest, LensFileOfAnotherSizeIsScaledIfTheAspectRatioAgrees) {
  const CaptureSet set = stitch_set(line(1), test_camera(440, 0.01), {.out = directory_ / "out"});
  EXPECT_NEAR(set.frame.width, default_panorama_width(camera_), 16);
  DualFisheyeCamera square = camera_;
  square.picture.width = square.picture.height;
  EXPECT_THROW(stitch_set(line(1), square, options()), Error);
}

TEST_F(StitchSetTest, FramesThatDoNotFitTheLensFileAreNamed) {
  EXPECT_THAT(message_of(line(1), std::nullopt), HasSubstr("raywalk-calibrate lens"));
  EXPECT_THROW(stitch_set(line(1), std::nullopt, options()), UsageError);
  camera_.two_files = true;
  EXPECT_THAT(message_of(line(2), camera_), HasSubstr("station x0_0: one picture, no back half"));
  CaptureSet set = line(2);
  for (CaptureFrame& frame : set.frames) frame.back = frame.file;
  set.frames[1].back.reset();
  EXPECT_THAT(message_of(set, camera_), HasSubstr("station x0_1"));
  camera_.two_files = false;
  EXPECT_THAT(message_of(set, camera_), HasSubstr("station x0_0: front and back in a file each"));
  EXPECT_FALSE(fs::exists(directory_ / "out"));
  set = line(3);
  write_image(set.frames[2].file,
              test_room().render(simulator::PanoramaRays(camera_.picture), kTestPose));
  EXPECT_THAT(message_of(set, camera_), HasSubstr("x0_2.png: bright around the image circles"));
  set = in_halves(2);
  write_image(directory_ / "small.png", cv::Mat(100, 100, CV_8UC3, cv::Scalar::all(0)));
  set.frames[1].back = directory_ / "small.png";
  EXPECT_THAT(message_of(set, camera_),
              HasSubstr("small.png: 100x100, but the other frames are 220x220"));
}

TEST_F(StitchSetTest, DamagedPicturesAreNamedAndLeaveNoPartialPanorama) {
  const CaptureSet set = line(3);
  const std::string whole = read_file(set.frames[1].file);
  std::ofstream(set.frames[1].file, std::ios::binary) << whole.substr(0, whole.size() / 2);
  EXPECT_THAT(message_of(set, camera_), HasSubstr("x0_1.png: the image is damaged or cut short"));
  EXPECT_FALSE(fs::exists(panorama(1)));
  fs::remove(set.frames[1].file);
  EXPECT_THAT(message_of(set, camera_), HasSubstr("x0_1.png"));
  // With the whole file restored, it resumes.
  write_file_atomically(set.frames[1].file, whole);
  EXPECT_EQ(message_of(set, camera_), "no error");
}

TEST_F(StitchSetTest, FilesForEachLensGiveTheSamePanoramas) {
  stitch_set(line(2), camera_, options());
  const cv::Mat of_one = read_panorama(panorama(1));
  const CaptureSet halves = in_halves(2);
  stitch_set(halves, camera_, options());
  EXPECT_GT(psnr_db(read_panorama(panorama(1)), of_one), 45.0);
}

// Some cameras mount their second sensor this way, and the lens file here does not.
TEST_F(StitchSetTest, BackLensUpsideDownIsFlagged) {
  const CaptureSet set = in_halves(4);
  for (const CaptureFrame& frame : set.frames) {
    cv::Mat turned;
    cv::flip(read_picture(*frame.back), turned, -1);
    write_image(*frame.back, turned);
  }
  stitch_set(set, camera_, options());
  EXPECT_THAT(record().at("warnings").at(0).get<std::string>(),
              HasSubstr("do not show the same along their seam"));
}

}  // namespace
}  // namespace raywalk::calibrate
