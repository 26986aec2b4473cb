#include "simulator/room/virtual_room.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/median.h"
#include "core/files/test_support.h"
#include "core/panorama/srgb.h"
#include "simulator/rig/rig_optics.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr PanoramaSize kSmall{64, 32};
constexpr PanoramaSize kLit{256, 128};

// The empty room and more.
VirtualRoom room_with(const std::string& more = "", const VirtualRoomSettings& settings = {}) {
  return {settings, parse_scene("include: [empty]\n" + more, "a scene")};
}

double distance_to_box(const RoomExtent& box, const Vector3d& from, const Vector3d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double wall = direction[axis] > 0.0 ? box.max_m[axis] : box.min_m[axis];
    nearest = std::min(nearest, (wall - from[axis]) / direction[axis]);
  }
  return nearest;
}

CameraPose random_pose(const RoomExtent& room, HashRandom* random) {
  CameraPose pose;
  for (int axis = 0; axis < 3; ++axis) {
    pose.position_m[axis] = random->uniform(room.min_m[axis], room.max_m[axis]);
  }
  pose.attitude = {random->uniform(-kPi, kPi), random->uniform(-kHalfPi, kHalfPi),
                   random->uniform(-kPi, kPi)};
  return pose;
}

// The grid's middle may be anywhere in the scene.
TEST(VirtualRoomTest, EmptyRoomHasTheDistancesOfABoxFromAnyPose) {
  HashRandom random(1);
  for (const Vector3d& middle_m : {Vector3d(0, 0, 0), Vector3d(0.3, -0.4, 1.1)}) {
    const VirtualRoom room = room_with("", {.scene = {.middle_m = middle_m}});
    EXPECT_EQ(room.extent().min_m, Vector3d(-2, -1.3, -2) - middle_m);
    for (int i = 0; i < 6; ++i) {
      const CameraPose pose = random_pose(room.extent(), &random);
      const cv::Mat map = room.distance_map(pose, kSmall);
      const Eigen::Matrix3d rotation = world_from_camera(pose.attitude);
      for (int v = 0; v < map.rows; ++v) {
        for (int u = 0; u < map.cols; ++u) {
          const Vector3d direction =
              rotation * direction_from_angles(angles_from_pixel(
                             {static_cast<double>(u), static_cast<double>(v)}, kSmall));
          const double expected = distance_to_box(room.extent(), pose.position_m, direction);
          ASSERT_NEAR(map.at<float>(v, u), expected, 1e-6 * expected) << u << "," << v;
        }
      }
    }
  }
}

// The shipped scenes: the space around the lines that their comments promise, and texture enough
// to find features.
TEST(VirtualRoomTest, ShippedRoomsAreFreeAroundTheirLinesAndTextured) {
  const auto sift = cv::SIFT::create();
  for (const auto& [file, half_m] :
       {std::pair{"room", 0.75}, std::pair{"study", 0.75}, std::pair{"large-room", 1.5}}) {
    const VirtualRoom room({.scene = {.file = file}});
    for (const double x : {-half_m, 0.0, half_m}) {
      for (const double z : {-half_m, 0.0, half_m}) {
        EXPECT_TRUE(room.is_free({x, 0.0, z}, 0.2)) << file << " " << x << " " << z;
      }
    }
    std::vector<cv::KeyPoint> found;
    sift->detect(room.render(PanoramaRays({1024, 512}), {}), found);
    EXPECT_GT(found.size(), 1000U) << file;
  }
}

TEST(VirtualRoomTest, CamerasOutsideTheRoomOrInsideObjectsAreRefused) {
  const VirtualRoom room =
      room_with("solids: [{box: [-2, 1.1, -0.1, 2, 1.3, 0.1], material: boards}]\n");
  const auto expect_refused = [&](const Vector3d& position_m, const char* message) {
    EXPECT_THAT(error_of([&] { room.distance_map({position_m, {}}, kSmall); }), HasSubstr(message));
  };
  expect_refused(room.extent().max_m + Vector3d(0.1, 0, 0), "outside the room");
  expect_refused({std::nan(""), 0, 0}, "no finite position");
  expect_refused({0.5, 1.2, 0.0}, "inside furniture");
  EXPECT_FALSE(room.is_free({0.5, 1.2, 0.0}, 0.01));
  EXPECT_FALSE(room.is_free({1.9, 0.0, 0.0}, 0.2));
  EXPECT_TRUE(room.is_free({1.7, 0.0, 0.0}, 0.2));
  EXPECT_THROW(room.distance_map({}, {64, 33}), Error);
  EXPECT_THROW(PanoramaRays({0, 0}), Error);
  EXPECT_THROW(VirtualRoom({.scene = {.file = "nowhere"}}), UsageError);
}

// Most of the window shows sky; the rest are hills, of a tenth of its light.
TEST(VirtualRoomTest, TheSkyIsInfinitelyFarAndClipsWhenItIsBrighter) {
  const std::string window =
      "materials: [{name: outside, pattern: sky}]\n"
      "solids: [{quad: [-0.5, -0.3, 1.99, 0.5, -0.3, 1.99, 0.5, 0.7, 1.99, -0.5, 0.7, 1.99],\n"
      "  material: outside}]\n";
  const VirtualRoom usual = room_with(window, {.light = {.clip = true}});
  const VirtualRoom bright = room_with(window, {.light = {.source_gain = 30.0, .clip = true}});
  const cv::Mat sky = usual.distance_map({}, kLit) == std::numeric_limits<float>::infinity();
  const int far = cv::countNonZero(sky);
  EXPECT_GT(far, 200);
  const cv::Mat empty = room_with().distance_map({}, kLit);
  EXPECT_EQ(cv::countNonZero(empty == std::numeric_limits<float>::infinity()), 0);
  const cv::Mat usually = usual.render(PanoramaRays(kLit), {});
  const cv::Mat brightly = bright.render(PanoramaRays(kLit), {});
  cv::Mat white, around, change;
  cv::inRange(brightly, cv::Scalar::all(255), cv::Scalar::all(255), white);
  EXPECT_GT(cv::countNonZero(white & sky), 0.8 * far);
  cv::absdiff(usually, brightly, change);
  cv::dilate(sky, around, cv::Mat());
  change.setTo(0, around);
  EXPECT_EQ(cv::norm(change, cv::NORM_INF), 0.0) << "the light that it casts stays the same";
}

TEST(VirtualRoomTest, ExposureMultipliesLightUpToWhite) {
  // Of plain paint, so that only pixels at edges have a number of rays that depends on the levels.
  const auto picture = [&](double exposure) {
    std::string paint = "materials:\n";
    for (const char* name : {"boards", "ceiling", "plaster", "bricks", "wallpaper", "tiles"}) {
      paint += std::string("  - {name: ") + name + "}\n";
    }
    return room_with(paint, {.light = {.exposure = exposure, .clip = true}})
        .render(PanoramaRays(kLit), {});
  };
  const cv::Mat usual = picture(1.0), brighter = picture(1.8);
  cv::Mat edges;
  cv::morphologyEx(usual, edges, cv::MORPH_GRADIENT, cv::Mat::ones(3, 3, CV_8U));
  int checked = 0;
  for (int v = 0; v < usual.rows; ++v) {
    for (int u = 0; u < usual.cols; ++u) {
      if (edges.at<cv::Vec3b>(v, u)[1] > 6) continue;
      const int from = usual.at<cv::Vec3b>(v, u)[1];
      const double expected =
          srgb_level_from_linear(std::min(1.8 * linear_from_srgb_level(from), 1.0));
      ASSERT_NEAR(brighter.at<cv::Vec3b>(v, u)[1], expected, 1.5) << u << "," << v;
      ++checked;
    }
  }
  EXPECT_GT(checked, 9 * usual.rows * usual.cols / 10);
}

Color seen_along(const VirtualRoom& room, const Vector3d& from, const Vector3d& direction) {
  return room.look(Ray{from, direction.normalized()}, 1e-5);
}

VirtualRoom room_with_pane(const std::string& pattern) {
  return room_with("materials: [{name: flat, pattern: " + pattern +
                   "}]\nsolids: [{quad: [-1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1],\n"
                   "  material: flat}]\n");
}

// A mirror shows the view of the mirrored camera.
TEST(RoomLightTest, MirrorShowsTheMirroredRoom) {
  const VirtualRoom room = room_with_pane("mirror");
  HashRandom random(5);
  for (int i = 0; i < 50; ++i) {
    const Vector3d on_mirror(random.uniform(-0.9, 0.9), random.uniform(-0.9, 0.9), 1.0);
    const Vector3d camera(0.1, 0.05, -0.2), image(0.1, 0.05, 2.2);
    const Color seen = seen_along(room, camera, on_mirror - camera);
    const Color expected = seen_along(room, on_mirror - Vector3d(0, 0, 1e-4), on_mirror - image);
    EXPECT_LT((seen - 0.92F * expected).cwiseAbs().maxCoeff(), 0.02F);
  }
}

TEST(RoomLightTest, PaneMixesWhatItReflectsWithWhatIsBehind) {
  const VirtualRoom room = room_with_pane("glass");
  const Vector3d before(0.2, 0.1, 0.9), behind(0.2, 0.1, 1.001), ahead(0, 0, 1);
  constexpr float kShare = 0.08F / 1.04F;  // straight ahead
  const Color expected =
      (1.0F - kShare) * seen_along(room, behind, ahead) + kShare * seen_along(room, before, -ahead);
  EXPECT_LT((seen_along(room, before, ahead) - expected).cwiseAbs().maxCoeff(), 0.01F);
  // The distance is that of what is behind.
  EXPECT_NEAR(room.measure(Ray{before, ahead}), 1.1, 1e-9);
}

TEST(VirtualRoomTest, MovingObjectsAreInFramesOnly) {
  const VirtualRoom room = room_with(
      "objects: [{name: post, solids: [{rod: [0, 0, 0, 0, 2, 0, 0.2, 0.2], material: tiles}]}]\n"
      "instances: [{object: post, at: [0, -1.3, 0], loop: [-1, 1, 1, 1], step_m: 1}]\n");
  const auto mean_column = [&](int station) {
    const cv::Mat mask = room.moving_mask(station, {}, kLit);
    const cv::Moments moments = cv::moments(mask.rowRange(40, 80), true);
    EXPECT_GT(moments.m00, 300.0);
    return moments.m10 / moments.m00;
  };
  // At x = -1, then 0: from 45 degrees to the left to straight ahead.
  EXPECT_NEAR(mean_column(0), 95.5, 1.0);
  EXPECT_NEAR(mean_column(1), 127.5, 1.0);
  const cv::Mat mask = room.moving_mask(1, {}, kLit), truth = room.render(PanoramaRays(kLit), {});
  cv::Mat change;
  cv::absdiff(room.render(PanoramaRays(kLit), {}, {.station = 1}), truth, change);
  cv::Mat unseen = mask == 0, grown;
  cv::erode(unseen, grown, cv::Mat());
  change.setTo(0, ~grown);
  EXPECT_EQ(cv::norm(change, cv::NORM_INF), 0.0) << "nothing else changes";
  EXPECT_EQ(
      cv::norm(room.distance_map({}, kSmall), room_with().distance_map({}, kSmall), cv::NORM_INF),
      0.0);
}

// At any attitude of the camera, even where furniture is between them.
TEST(DollyTest, CoversTheNadirUpToItsReach) {
  const VirtualRoom room =
      room_with("solids: [{box: [-0.5, -1.3, -0.5, 0.5, -0.6, 0.5], material: tiles}]\n");
  const PanoramaRays camera({720, 360});
  const CameraPose pose{{0, 0, 0}, {0.3, 0.02, -0.01}};
  for (const double reach_deg : {12.0, 20.0, 40.0}) {
    const Facets dolly = make_dolly({true, reach_deg}, 1.3);
    cv::Mat change, changed;
    cv::absdiff(room.render(camera, pose, {.carried = &dolly}), room.render(camera, pose), change);
    cv::transform(change, changed, cv::Matx13f(1, 1, 1));
    // Rows of half a degree; the middle of an edge is ahead.
    const auto share = [&](double from_nadir_deg) {
      const int row = 359 - static_cast<int>(2.0 * from_nadir_deg);
      return cv::countNonZero(changed.row(row).colRange(355, 366) > 6) / 11.0;
    };
    EXPECT_GT(share(reach_deg - 1.5), 0.7) << reach_deg;
    EXPECT_EQ(share(reach_deg + 4.0), 0.0) << reach_deg;
    EXPECT_EQ(cv::countNonZero(changed.rowRange(0, 240)), 0) << "30 degrees and more up";
  }
  EXPECT_THROW(make_dolly({true, 20.0}, 0.0), Error);
}

// --- Rendered views of a furnished room are consistent with its geometry ------------------------

constexpr PanoramaSize kViewSize{512, 256};

// Bilinear.
cv::Vec3d sample(const cv::Mat& picture, PixelPosition at) {
  cv::Mat_<cv::Vec3b> pixel;
  cv::getRectSubPix(picture, {1, 1}, cv::Point2d(at.u, at.v), pixel);
  return pixel(0, 0);
}

double mean_difference(const cv::Vec3d& a, const cv::Vec3d& b) {
  return (std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2])) / 3.0;
}

// Lighting it takes a second.
const VirtualRoom& study() {
  static const VirtualRoom room({.scene = {.file = "study"}});
  return room;
}

struct View {
  CameraPose pose;
  cv::Mat picture;
  cv::Mat distance;
};

// `source` warped to `target` by its distances; only points visible in both.
std::vector<double> differences(const View& target, const View& source, bool reproject) {
  std::vector<double> found;
  const Eigen::Matrix3d target_rotation = world_from_camera(target.pose.attitude);
  const Eigen::Matrix3d source_rotation = world_from_camera(source.pose.attitude);
  for (int v = 20; v < kViewSize.height - 20; ++v) {
    for (int u = 0; u < kViewSize.width; ++u) {
      const PixelPosition pixel{static_cast<double>(u), static_cast<double>(v)};
      const double distance = target.distance.at<float>(v, u);
      if (std::isinf(distance)) continue;
      const Vector3d point =
          target.pose.position_m +
          distance * (target_rotation * direction_from_angles(angles_from_pixel(pixel, kViewSize)));
      const Vector3d from = source.pose.position_m;
      const PixelPosition seen = pixel_from_angles(
          angles_from_direction(source_rotation.transpose() * (point - from)), kViewSize);
      const int near_u =
          (static_cast<int>(std::lround(seen.u)) + kViewSize.width) % kViewSize.width;
      const int near_v = std::clamp(static_cast<int>(std::lround(seen.v)), 0, kViewSize.height - 1);
      const double true_distance = (point - from).norm();
      if (std::abs(source.distance.at<float>(near_v, near_u) - true_distance) >
          0.02 * true_distance) {
        continue;
      }
      found.push_back(mean_difference(sample(source.picture, reproject ? seen : pixel),
                                      cv::Vec3d(target.picture.at<cv::Vec3b>(v, u))));
    }
  }
  return found;
}

TEST(RoomViewsTest, ViewWarpedByItsDistancesIsTheOtherView) {
  const auto view_from = [&](const CameraPose& pose) {
    return View{pose, study().render(PanoramaRays(kViewSize), pose),
                study().distance_map(pose, kViewSize)};
  };
  const View centre = view_from({});
  const View moved = view_from({{0.25, -0.05, 0.3}, {0.4, 0.1, -0.15}});
  const std::vector<double> reprojected = differences(centre, moved, true);
  ASSERT_GT(reprojected.size(), static_cast<std::size_t>(kViewSize.width * kViewSize.height / 2));
  EXPECT_LT(median(reprojected), 2.5);
  // Without the warp the difference is large.
  EXPECT_GT(median(differences(centre, moved, false)), 15.0);
}

TEST(RoomViewsTest, FisheyeAndPanoramaShowTheSameInEveryDirection) {
  const CameraPose pose{{-0.1, 0.02, 0.15}, {0.7, -0.2, 0.1}};
  DualFisheyeLayout layout = simple_dual_fisheye({768, 384});
  layout.front.k = {0.02, -0.005, 0.001, -0.0002};
  layout.front.focal_px *= 0.97;
  layout.back_attitude = {kPi + 0.01, 0.02, -0.03};
  const cv::Mat frame = study().render(DualFisheyeRays(layout, {768, 384}), pose);
  const cv::Mat panorama = study().render(PanoramaRays(kViewSize), pose);
  for (const auto& [lens, attitude] :
       {std::pair{layout.front, Attitude{}}, {layout.back, layout.back_attitude}}) {
    const Eigen::Matrix3d camera_from_lens = world_from_camera(attitude);
    std::vector<double> differences;
    for (int v = 16; v < kViewSize.height - 16; v += 2) {
      for (int u = 0; u < kViewSize.width; u += 2) {
        const PixelPosition pixel{static_cast<double>(u), static_cast<double>(v)};
        const Vector3d direction = camera_from_lens.transpose() *
                                   direction_from_angles(angles_from_pixel(pixel, kViewSize));
        const auto at = project(lens, direction);
        if (!at || direction.z() <= 0.1) continue;
        differences.push_back(
            mean_difference(sample(frame, *at), cv::Vec3d(panorama.at<cv::Vec3b>(v, u))));
      }
    }
    ASSERT_GT(differences.size(), 2000U);
    EXPECT_LT(median(differences), 4.0);
  }
  EXPECT_EQ(frame.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(frame.at<cv::Vec3b>(383, 767), cv::Vec3b(0, 0, 0));
}

TEST(DualFisheyeTest, BackLensLooksBackFromItsPosition) {
  DualFisheyeLayout layout = simple_dual_fisheye({400, 200});
  layout.back_position_m = {0, 0, -0.02};
  const DualFisheyeRays rays(layout, {400, 200});
  // Parts 7 and 8 of 16 are on either side of a pixel's centre; the image centre is between two
  // pixels.
  const auto front = rays.at_part(100 * kPixelParts, 100 * kPixelParts);
  const auto back = rays.at_part(300 * kPixelParts, 100 * kPixelParts);
  ASSERT_TRUE(front && back);
  EXPECT_GT(front->direction.z(), 0.9999);
  EXPECT_LT(back->direction.z(), -0.9999);
  EXPECT_EQ(front->origin_m, Vector3d(0, 0, 0));
  EXPECT_EQ(back->origin_m, Vector3d(0, 0, -0.02));
  // To the right in the back lens's image is the camera's left.
  EXPECT_LT(rays.at_part(350 * kPixelParts, 100 * kPixelParts)->direction.x(), -0.5);
  EXPECT_FALSE(rays.at_part(0, 0));
}

TEST(DualFisheyeTest, NonMonotonicAndNonFiniteLensesAreRefused) {
  DualFisheyeLayout layout = simple_dual_fisheye({400, 200});
  layout.back.k = {-0.3, 0, 0, 0};
  EXPECT_THROW(DualFisheyeRays(layout, {400, 200}), Error);
  layout.back.k = {0, std::nan(""), 0, 0};
  EXPECT_THROW(DualFisheyeRays(layout, {400, 200}), Error);
}

}  // namespace
}  // namespace raywalk::simulator
