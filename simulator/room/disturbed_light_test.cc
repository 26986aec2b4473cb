// Exposure, clipping, glass and plain walls.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/panorama/srgb.h"
#include "simulator/room/test_rooms.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

constexpr PanoramaSize kLitSize{256, 128};

int white_pixels(const cv::Mat& image) {
  return static_cast<int>(
      std::count(image.begin<cv::Vec3b>(), image.end<cv::Vec3b>(), cv::Vec3b::all(255)));
}

// Most of the window shows sky; the rest are hills, of a tenth of its light.
TEST(DisturbedLightTest, WindowClipsWhenTheSkyIsBrighter) {
  VirtualRoomSettings settings = empty_room(8, 1.0);
  settings.contents.window = true;
  const VirtualRoom usual(settings);
  settings.light = {.exposure = 1.0, .source_gain = 30.0, .clip = true};
  const VirtualRoom bright(settings);
  const cv::Mat distance = usual.distance_map({}, kLitSize);
  const auto far = std::count_if(distance.begin<float>(), distance.end<float>(),
                                 [](float metres) { return std::isinf(metres); });
  EXPECT_EQ(white_pixels(usual.panorama({}, kLitSize)), 0);
  const int white = white_pixels(bright.panorama({}, kLitSize));
  EXPECT_GT(white, 0.8 * static_cast<double>(far));
  EXPECT_LT(white, 1.4 * static_cast<double>(far) + 60.0) << "else only sunlit paint is white";
}

TEST(DisturbedLightTest, ExposureMultipliesLightUpToWhite) {
  VirtualRoomSettings settings = empty_room(4, 1.0);
  settings.light.clip = true;
  // One ray per pixel, as the number of rays depends on the levels.
  const cv::Mat usual = VirtualRoom(settings).panorama({}, kLitSize, Sampling::kDraft);
  settings.light.exposure = 1.8;
  const cv::Mat brighter = VirtualRoom(settings).panorama({}, kLitSize, Sampling::kDraft);
  for (int v = 0; v < usual.rows; ++v) {
    for (int u = 0; u < usual.cols; ++u) {
      const int from = usual.at<cv::Vec3b>(v, u)[1];
      const double expected =
          srgb_level_from_linear(std::min(1.8 * linear_from_srgb_level(from), 1.0));
      ASSERT_NEAR(brighter.at<cv::Vec3b>(v, u)[1], expected, 1.5) << u << "," << v;
    }
  }
}

TEST(DisturbedLightTest, PaneMixesWhatItReflectsWithWhatIsBehind) {
  VirtualRoomSettings settings = empty_room(8, 1.0);
  settings.contents.glass = 1;
  const RoomPlan plan = plan_room(settings);
  const RoomScene scene(plan, settings);
  ASSERT_EQ(scene.glass().facets.size(), 1U);
  const Facet& pane = scene.glass().facets.front();
  const Vector3d middle = 0.5 * (pane.corners[0] + pane.corners[2]);
  const Vector3d before = middle + 0.1 * pane.normal, behind = middle - 0.001 * pane.normal;
  const auto look = [&](const Vector3d& from, const Vector3d& direction) {
    const Ray ray{from, direction};
    Color seen;
    scene.look({&ray, 1}, 1e-4, {&seen, 1});
    return seen;
  };
  const Color seen = look(before, -pane.normal);
  const Color through = look(behind, -pane.normal), reflected = look(before, pane.normal);
  constexpr float kShare = 0.08F / 1.04F;  // straight ahead
  const Color expected = (1.0F - kShare) * through + kShare * reflected;
  EXPECT_LT((seen - expected).cwiseAbs().maxCoeff(), 0.01F);
  // The distance is that of what is behind.
  const Ray ray{before, -pane.normal}, rest{behind, -pane.normal};
  double whole = 0.0, beyond = 0.0;
  scene.measure({&ray, 1}, {&whole, 1});
  scene.measure({&rest, 1}, {&beyond, 1});
  EXPECT_NEAR(whole, beyond + 0.101, 1e-5);
}

TEST(DisturbedLightTest, GlassLeavesEverythingElseInPlace) {
  VirtualRoomSettings settings = empty_room(8, 1.0);
  const cv::Mat without = VirtualRoom(settings).distance_map({}, kLitSize);
  settings.contents.glass = 1;
  const cv::Mat with = VirtualRoom(settings).distance_map({}, kLitSize);
  int frame = 0;
  for (int v = 0; v < with.rows; ++v) {
    for (int u = 0; u < with.cols; ++u) {
      const float a = without.at<float>(v, u), b = with.at<float>(v, u);
      if (a == b) continue;
      ASSERT_LT(b, a) << "only the frame hides something";
      ++frame;
    }
  }
  EXPECT_GT(frame, 20);
  EXPECT_LT(frame, 1500) << "of 32,768 pixels";
}

TEST(DisturbedLightTest, PlainWallsHaveNoTexture) {
  VirtualRoomSettings settings = empty_room(4, 1.0);
  const auto contrast_of_upper_half = [&] {
    cv::Mat grey, slope;
    cv::cvtColor(VirtualRoom(settings).panorama({}, kLitSize), grey, cv::COLOR_BGR2GRAY);
    cv::Laplacian(grey.rowRange(8, 60), slope, CV_32F);
    return cv::mean(cv::abs(slope))[0];
  };
  const double usual = contrast_of_upper_half();
  settings.contents.plain_walls = 4;
  settings.contents.plain_ceiling = true;
  EXPECT_LT(contrast_of_upper_half(), 0.25 * usual);
}

}  // namespace
}  // namespace raywalk::capture
