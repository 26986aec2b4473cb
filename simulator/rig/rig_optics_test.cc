#include "simulator/rig/rig_optics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/files/lens_file.h"
#include "core/files/test_directory.h"

namespace raywalk::simulator {
namespace {

using ::testing::HasSubstr;

constexpr PanoramaSize kFrame{160, 80};
constexpr double kFloor_m = 1.2;

const VirtualRoom& empty_room() {
  static const VirtualRoom room = [] {
    VirtualRoomSettings settings;
    settings.scene.file = "empty";
    return VirtualRoom(settings);
  }();
  return room;
}

RigCameraSettings dual_fisheye() {
  RigCameraSettings camera;
  camera.layout = FrameKind::kDualFisheye;
  return camera;
}

RigOptics optics_of(const RigCameraSettings& camera, const DollySettings& dolly = {}) {
  return {camera, kFrame, dolly, kFloor_m, 1};
}

cv::Mat picture_of(const RigCameraSettings& camera, const DollySettings& dolly = {},
                   std::uint64_t number = 1) {
  ExposureNow exposure;
  exposure.number = number;
  const RigOptics optics = optics_of(camera, dolly);
  return optics.picture(optics.scene(empty_room(), {}), exposure);
}

double mean_of(const cv::Mat& picture) { return cv::mean(picture)[1]; }

TEST(RigOpticsTest, SeesThroughTheLensesOfItsFileAtItsOwnSize) {
  const TestDirectory directory;
  DualFisheyeCamera lens;
  lens.picture = {1600, 800};
  lens.layout = simple_dual_fisheye(lens.picture);
  lens.layout.front.centre.u += 40.0;
  lens.layout.back.k[0] = 0.02;
  write_lens_file(directory / "lens.yaml", lens);
  RigCameraSettings camera = dual_fisheye();
  const cv::Mat simple = picture_of(camera);
  camera.lens = directory / "lens.yaml";
  const RigOptics optics = optics_of(camera);
  EXPECT_NEAR(optics.lenses()->front.centre.u, simple_dual_fisheye(kFrame).front.centre.u + 4.0,
              1e-9);
  EXPECT_EQ(optics.lenses()->back.k[0], 0.02);
  EXPECT_GT(cv::norm(picture_of(camera), simple, cv::NORM_INF), 30.0);
  EXPECT_FALSE(optics_of({}).lenses());
}

TEST(RigOpticsTest, LensFilesOfOtherLayoutsAreRefused) {
  const TestDirectory directory;
  DualFisheyeCamera lens;
  lens.picture = {1600, 900};
  lens.layout = simple_dual_fisheye({1600, 800});
  RigCameraSettings camera = dual_fisheye();
  camera.lens = directory / "lens.yaml";
  const auto expect_refused = [&](const std::string& message) {
    try {
      optics_of(camera);
      ADD_FAILURE() << message;
    } catch (const UsageError& e) {
      EXPECT_THAT(e.what(), HasSubstr("lens.yaml"));
      EXPECT_THAT(e.what(), HasSubstr(message));
    }
  };
  expect_refused("not a file");
  write_lens_file(camera.lens, lens);
  expect_refused("1600 x 900");
  lens.picture = {1600, 800};
  lens.two_files = true;
  write_lens_file(camera.lens, lens);
  expect_refused("two files");
}

TEST(RigOpticsTest, LensesHaveVignettingAndDifferentGain) {
  RigCameraSettings camera = dual_fisheye();
  const cv::Mat even = picture_of(camera);
  camera.light.lens_gain_ev = -1.0;
  const cv::Mat darker_back = picture_of(camera);
  EXPECT_EQ(cv::norm(even.colRange(0, 80), darker_back.colRange(0, 80), cv::NORM_INF), 0.0);
  EXPECT_LT(mean_of(darker_back.colRange(80, 160)), 0.85 * mean_of(even.colRange(80, 160)));
  camera.light = {0.5, 0.0};
  const cv::Mat vignetted = picture_of(camera);
  const cv::Rect middle(36, 36, 8, 8), rim(36, 2, 8, 4);
  EXPECT_NEAR(mean_of(vignetted(middle)), mean_of(even(middle)), 2.0);
  EXPECT_LT(mean_of(vignetted(rim)), 0.85 * mean_of(even(rim)));
}

TEST(RigOpticsTest, LightDriftsSlowlyAndWithinItsBounds) {
  double largest = 0.0, largest_step = 0.0;
  for (int seed = 1; seed <= 5; ++seed) {
    for (std::uint64_t picture = 1; picture <= 400; ++picture) {
      const double here = exposure_drift(picture, seed);
      largest = std::max(largest, std::abs(here));
      largest_step = std::max(largest_step, std::abs(exposure_drift(picture + 1, seed) - here));
    }
  }
  EXPECT_GT(largest, 0.8);
  EXPECT_LE(largest, 1.0);
  EXPECT_LT(largest_step, 0.12);
  RigCameraSettings camera;
  EXPECT_EQ(mean_of(picture_of(camera, {}, 1)), mean_of(picture_of(camera, {}, 30)));
  camera.exposure_drift_ev = 0.5;
  EXPECT_GT(std::abs(mean_of(picture_of(camera, {}, 1)) - mean_of(picture_of(camera, {}, 30))),
            2.0);
}

}  // namespace
}  // namespace raywalk::simulator
