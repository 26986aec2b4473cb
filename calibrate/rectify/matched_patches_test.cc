#include "calibrate/rectify/matched_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibrate/rectify/exposure_gains.h"
#include "capture/simulated/virtual_room/virtual_room.h"

namespace raywalk::calibrate {
namespace {

constexpr PanoramaSize kSeen{512, 256};

const capture::VirtualRoom& room() {
  static const capture::VirtualRoom room{capture::VirtualRoomSettings{}};
  return room;
}

// A station at `position_m`, turned, exposed by `light`; `mask` may be empty. What the frame's own
// mask hides is painted over.
ComparedPanorama station(const Eigen::Vector3d& position_m, double light, const cv::Mat& mask,
                         bool own_mask = false) {
  const Attitude attitude{0.3 * position_m.x(), 0.02, -0.03};
  cv::Mat picture = room().panorama({position_m, attitude}, kSeen);
  const LevelsUnderGain levels(LightGain{light, light, light});
  for (auto pixel = picture.begin<cv::Vec3b>(); pixel != picture.end<cv::Vec3b>(); ++pixel) {
    *pixel = cv::Vec3b(levels(cv::Vec3f(*pixel)));
  }
  if (own_mask) {
    cv::Mat paint(picture.size(), CV_8UC3);
    cv::randu(paint, 40, 200);
    paint.copyTo(picture, mask == 0);
  }
  return {picture,
          mask,
          own_mask,
          {.position_m = position_m, .world_from_camera = world_from_camera(attitude)}};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double median_log_ratio(const std::vector<MatchedPatch>& patches) {
  std::vector<double> ratios;
  for (const MatchedPatch& patch : patches) ratios.push_back(patch.log_ratio.mean());
  return median(ratios);
}

TEST(MatchedPatchesTest, ParallaxDoesNotChangeTheRatio) {
  const Eigen::Vector3d step(0.1, 0.0, 0.03);
  for (const double light : {1.0, 1.1}) {
    const auto patches = match_patches(station(-step, 1.0, {}), station(step, light, {}));
    EXPECT_GT(patches.size(), 150U);
    EXPECT_NEAR(median_log_ratio(patches), std::log(light), 0.004);
  }
}

TEST(MatchedPatchesTest, SurfacesAreFoundAtTheirDistance) {
  const Eigen::Vector3d from(-0.1, 0.0, 0.0), to(0.1, 0.0, 0.0);
  std::vector<double> errors;
  for (const MatchedPatch& patch : match_patches(station(from, 1.0, {}), station(to, 1.0, {}))) {
    // Seen from either side the surface lies where the camera sees it.
    const Attitude attitude{0.3 * from.x(), 0.02, -0.03};
    const Eigen::Vector3d seen = world_from_camera(attitude) * patch.seen_from;
    errors.push_back(((patch.point_m - from).normalized() - seen).norm());
    EXPECT_NEAR(patch.parallax, 0.2 / (patch.point_m - from).norm(), 0.2 * patch.parallax + 0.02);
  }
  EXPECT_LT(median(errors), 0.002);
}

TEST(MatchedPatchesTest, MaskedSurfacesAreNotUsed) {
  cv::Mat mask(kSeen.height, kSeen.width, CV_8UC1, cv::Scalar(255));
  mask.rowRange(kSeen.height / 2, kSeen.height) = cv::Scalar(0);
  const Eigen::Vector3d step(0.05, 0.0, 0.0);
  const auto patches = match_patches(station(-step, 1.0, mask), station(step, 1.0, mask));
  EXPECT_GT(patches.size(), 50U);
  for (const MatchedPatch& patch : patches) {
    EXPECT_GT(patch.seen_from.y(), -0.06);
    EXPECT_GT(patch.seen_to.y(), -0.06);
  }
}

// The same lower half of the same picture, which would match well.
TEST(MatchedPatchesTest, NoPatchTouchesWhatAFramesOwnMaskHides) {
  cv::Mat mask(kSeen.height, kSeen.width, CV_8UC1, cv::Scalar(255));
  mask.rowRange(kSeen.height / 2, kSeen.height) = cv::Scalar(0);
  const Eigen::Vector3d here(0.05, 0.0, 0.0);
  const auto patches =
      match_patches(station(here, 1.0, mask, true), station(here, 1.0, mask, true));
  EXPECT_GT(patches.size(), 100U);
  const double patch_rad = kPatchRadius_px * kTwoPi / kSeen.width;
  for (const MatchedPatch& patch : patches) {
    EXPECT_GT(patch.seen_from.y(), patch_rad);
    EXPECT_GT(patch.seen_to.y(), patch_rad);
  }
}

// Lines cross at stations that stand at one place.
TEST(MatchedPatchesTest, StationsAtOnePlaceAreCompared) {
  const Eigen::Vector3d here(0.05, 0.0, 0.0);
  const auto patches = match_patches(station(here, 1.0, {}), station(here, 0.95, {}));
  EXPECT_GT(patches.size(), 300U);
  EXPECT_NEAR(median_log_ratio(patches), std::log(0.95), 0.002);
  for (const MatchedPatch& patch : patches) EXPECT_TRUE(patch.point_m.allFinite());
}

}  // namespace
}  // namespace raywalk::calibrate
