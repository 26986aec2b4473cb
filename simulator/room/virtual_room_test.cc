#include "simulator/room/virtual_room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/test_rooms.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr PanoramaSize kSmall{64, 32};

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

bool same_bytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() &&
         std::equal(a.datastart, a.dataend, b.datastart);
}

TEST(VirtualRoomTest, EmptyRoomHasTheDistancesOfABoxAtAnyScaleAndPose) {
  HashRandom random(1);
  for (int i = 0; i < 12; ++i) {
    const double side_m = 0.2 * std::pow(25.0, random.uniform());
    const VirtualRoom room(empty_room(i, side_m));
    const CameraPose pose = random_pose(room.extent(), &random);
    const cv::Mat map = room.distance_map(pose, kSmall);
    const Eigen::Matrix3d rotation = world_from_camera(pose.attitude);
    for (int v = 0; v < map.rows; ++v) {
      for (int u = 0; u < map.cols; ++u) {
        const Vector3d direction =
            rotation * direction_from_angles(angles_from_pixel(
                           {static_cast<double>(u), static_cast<double>(v)}, kSmall));
        const double expected = distance_to_box(room.extent(), pose.position_m, direction);
        ASSERT_NEAR(map.at<float>(v, u), expected, 1e-6 * expected)
            << "seed " << i << ", side " << side_m << ", pixel " << u << "," << v;
      }
    }
  }
}

TEST(VirtualRoomTest, GivenSizesAreKept) {
  VirtualRoomSettings settings = empty_room(4, 0.5);
  settings.room = {4.0, 5.0, 2.6, 1.4, 1.0};
  const RoomExtent room = VirtualRoom(settings).extent();
  const Vector3d size = room.max_m - room.min_m;
  EXPECT_NEAR(size.x(), 4.0, 1e-12);
  EXPECT_NEAR(size.y(), 2.6, 1e-12);
  EXPECT_NEAR(size.z(), 5.0, 1e-12);
  EXPECT_NEAR(room.min_m.y(), -1.4, 1e-12);
}

// A factor of two scales every number exactly.
TEST(VirtualRoomTest, LargerRoomIsTheSameRoomScaled) {
  const VirtualRoom room(furnished_room(5)), larger(furnished_room(5, 4.0));
  const CameraPose pose{{0.2, 0.05, -0.4}, {0.3, 0.1, -0.2}};
  CameraPose scaled = pose;
  scaled.position_m *= 4.0;
  const cv::Mat scaled_back = larger.distance_map(scaled, kSmall) / 4.0;
  EXPECT_TRUE(same_bytes(scaled_back, room.distance_map(pose, kSmall)));
  EXPECT_TRUE(same_bytes(larger.panorama(scaled, kSmall), room.panorama(pose, kSmall)));
}

TEST(VirtualRoomTest, SmallRoomKeepsProportions) {
  const VirtualRoom room(furnished_room(6)), small(furnished_room(6, 0.2));
  const cv::Mat expected = room.distance_map({}, kSmall) * 0.2;
  const cv::Mat actual = small.distance_map({}, kSmall);
  for (int v = 0; v < actual.rows; ++v) {
    for (int u = 0; u < actual.cols; ++u) {
      const float want = expected.at<float>(v, u), got = actual.at<float>(v, u);
      ASSERT_TRUE(want == got || std::abs(want - got) < 1e-5F * want) << u << "," << v;
    }
  }
}

TEST(VirtualRoomTest, SameSettingsGiveTheSameBytesOnAnyNumberOfThreads) {
  const CameraPose pose{{0.1, 0.0, 0.2}, {}};
  set_thread_count(1);
  const VirtualRoom alone(furnished_room(7));
  const cv::Mat picture = alone.panorama(pose, {256, 128}), map = alone.distance_map(pose, kSmall);
  set_thread_count(4);
  const VirtualRoom shared(furnished_room(7));
  EXPECT_TRUE(same_bytes(shared.panorama(pose, {256, 128}), picture));
  EXPECT_TRUE(same_bytes(shared.distance_map(pose, kSmall), map));
  set_thread_count(0);
}

TEST(VirtualRoomTest, SeedsDiffer) {
  const VirtualRoom one(furnished_room(8)), other(furnished_room(9));
  const cv::Mat a = one.distance_map({}, kSmall), b = other.distance_map({}, kSmall);
  int different = 0;
  for (int v = 0; v < a.rows; ++v) {
    for (int u = 0; u < a.cols; ++u) {
      const float near = std::min(a.at<float>(v, u), b.at<float>(v, u));
      if (std::abs(a.at<float>(v, u) - b.at<float>(v, u)) > 0.05F * near) ++different;
    }
  }
  EXPECT_GT(different, a.rows * a.cols / 2);
}

TEST(VirtualRoomTest, OnlyTheSkyIsInfinitelyFar) {
  const VirtualRoom room(furnished_room(8));
  VirtualRoomSettings settings = furnished_room(8);
  settings.contents.window = false;
  const cv::Mat with = room.distance_map({}, {256, 128});
  const cv::Mat without = VirtualRoom(settings).distance_map({}, {256, 128});
  const auto infinite = [](float metres) { return std::isinf(metres); };
  EXPECT_GT(std::count_if(with.begin<float>(), with.end<float>(), infinite), 50);
  EXPECT_EQ(std::count_if(without.begin<float>(), without.end<float>(), infinite), 0);
}

TEST(VirtualRoomTest, NothingIsNearerToTheLinesThanAQuarterOfACellAtCameraHeight) {
  for (int seed = 20; seed < 22; ++seed) {
    VirtualRoomSettings settings = furnished_room(seed, 2.0);
    settings.grid.cells_x = 1 + seed % 2;
    const VirtualRoom room(settings);
    for (const PlannedLine& line : room.plan().lines) {
      for (const double along : {line.along.front(), line.along.back()}) {
        const Vector3d at_m = room.plan().unit_m * line.position(along);
        const cv::Mat map = room.distance_map({at_m, {}}, {256, 128});
        double nearest = 0.0;
        cv::minMaxLoc(map.rowRange(62, 66), &nearest);
        EXPECT_GE(nearest, 0.5 * (1.0 - 1e-3)) << "seed " << seed << ", line " << line.id;
      }
    }
  }
}

TEST(VirtualRoomTest, CamerasOutsideTheRoomOrInsideObjectsAreRefused) {
  const VirtualRoom room(furnished_room(3));
  const Vector3d outside = room.extent().max_m + Vector3d(0.1, 0, 0);
  try {
    room.panorama({outside, {}}, kSmall);
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("virtual room of seed 3"));
    EXPECT_THAT(e.what(), HasSubstr("outside the room"));
  }
  EXPECT_THROW(room.distance_map({{std::nan(""), 0, 0}, {}}, kSmall), Error);
  EXPECT_THROW(room.panorama({}, {64, 33}), Error);
  EXPECT_THROW(room.panorama({}, {0, 0}), Error);
}

// The room is empty except for beams, so every point close to the ceiling is free or inside one.
TEST(VirtualRoomTest, CamerasInsideABeamAreRefused) {
  VirtualRoomSettings settings = empty_room(3, 1.0);
  settings.contents.beams = true;
  const VirtualRoom room(settings);
  const RoomExtent extent = room.extent();
  int refused = 0, free = 0;
  for (int i = 1; i < 40; ++i) {
    Vector3d at = extent.min_m + i / 40.0 * (extent.max_m - extent.min_m);
    at.y() = extent.max_m.y() - 0.03;
    try {
      room.distance_map({at, {}}, {8, 4});
      ++free;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("inside furniture"));
      ++refused;
    }
  }
  EXPECT_GE(refused, 2);
  EXPECT_GE(free, 20);
}

TEST(VirtualRoomTest, RoomTooSmallForItsContentsIsRefused) {
  VirtualRoomSettings settings = furnished_room(1);
  settings.contents.chairs = 100;
  settings.room.width_m = 2.2;
  settings.room.depth_m = 2.2;
  settings.contents.shelf = settings.contents.plant = settings.contents.coat_stand = false;
  settings.contents.lamp = false;
  try {
    const VirtualRoom room(settings);
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_THAT(e.what(), HasSubstr("seed 1"));
    EXPECT_THAT(e.what(), HasSubstr("no space left"));
  }
}

}  // namespace
}  // namespace raywalk::capture
