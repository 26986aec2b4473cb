#include "simulator/room/walking_people.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "simulator/room/test_rooms.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr PanoramaSize kWalkSize{256, 128};

VirtualRoomSettings with_people(int count, double step_mm) {
  VirtualRoomSettings settings = empty_room(3, 1.0);
  settings.people = {.count = count, .step_mm = step_mm};
  return settings;
}

// Where the mask is empty, a frame with people is the frame without; where it is set, they cover
// most of what is there. The mask's edge is that of pixel centres, so edges are left out.
TEST(WalkingPeopleTest, PeopleCoverThePixelsOfTheirMaskOnly) {
  const VirtualRoom room(with_people(4, 400.0));
  const CameraPose pose{{0.5, 0.0, -0.3}, {}};
  const cv::Mat without = room.panorama(pose, kWalkSize);
  const cv::Mat with = room.panorama_with_people(5, pose, kWalkSize);
  const cv::Mat mask = room.people_mask(5, pose, kWalkSize);
  int covered = 0, changed = 0, disturbed = 0;
  for (int v = 1; v + 1 < mask.rows; ++v) {
    for (int u = 1; u + 1 < mask.cols; ++u) {
      const double around = cv::sum(mask(cv::Rect(u - 1, v - 1, 3, 3)))[0];
      const cv::Vec3b a = without.at<cv::Vec3b>(v, u), b = with.at<cv::Vec3b>(v, u);
      if (around == 0.0 && a != b) ++disturbed;
      if (around < 9.0 * 255.0) continue;
      ++covered;
      if (cv::norm(a, b, cv::NORM_INF) > 8.0) ++changed;
    }
  }
  EXPECT_EQ(disturbed, 0);
  EXPECT_GT(covered, 300) << "of 32,768 pixels";
  EXPECT_GT(changed, 0.8 * covered);
}

// Seen from where a person stands at one moment, everybody is a step further at the next.
TEST(WalkingPeopleTest, EverybodyWalksAStepFromStationToStation) {
  const VirtualRoomSettings settings = with_people(3, 400.0);
  const RoomPlan plan = plan_room(settings);
  const RoomScene scene(plan, settings);
  const PeoplePath path(plan, scene.geometry(), settings.people);
  int straight = 0;
  for (int moment = 0; moment < 20; ++moment) {
    const auto here = path.at(moment), next = path.at(moment + 1);
    ASSERT_EQ(here.size(), 3U);
    for (std::size_t i = 0; i < here.size(); ++i) {
      const double step = (next[i].origin - here[i].origin).norm();
      EXPECT_LT(step, 0.46);  // of whole places, less around a corner
      if (step > 0.34) ++straight;
      for (const PlannedLine& line : plan.lines) {
        for (const double along : line.along) {
          const Vector3d off = line.position(along) - here[i].origin;
          EXPECT_GT(std::hypot(off.x(), off.z()), plan.clearance);
        }
      }
    }
  }
  EXPECT_GT(straight, 40) << "of 60 steps";
}

TEST(WalkingPeopleTest, DistancesAreThoseOfTheRoomWithoutThem) {
  const VirtualRoom crowded(with_people(4, 400.0)), alone(empty_room(3, 1.0));
  EXPECT_EQ(cv::norm(crowded.distance_map({}, kWalkSize), alone.distance_map({}, kWalkSize),
                     cv::NORM_INF),
            0.0);
  EXPECT_EQ(cv::norm(crowded.panorama({}, kWalkSize), alone.panorama({}, kWalkSize), cv::NORM_INF),
            0.0);
  EXPECT_EQ(cv::norm(alone.panorama_with_people(7, {}, kWalkSize), alone.panorama({}, kWalkSize),
                     cv::NORM_INF),
            0.0)
      << "nobody walks unless asked for";
  EXPECT_EQ(cv::countNonZero(alone.people_mask(7, {}, kWalkSize)), 0);
}

TEST(WalkingPeopleTest, MorePeopleThanFindPlaceAreRefused) {
  VirtualRoomSettings settings = with_people(20, 400.0);
  settings.room.width_m = settings.room.depth_m = 2.3;  // the lines and little beside them
  settings.grid.overhang_share = 0.0;
  try {
    const VirtualRoom room(settings);
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_THAT(e.what(), HasSubstr("free floor to walk on"));
    EXPECT_THAT(e.what(), HasSubstr("people.count"));
  }
}

}  // namespace
}  // namespace raywalk::capture
