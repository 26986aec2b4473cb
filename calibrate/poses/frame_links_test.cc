#include "calibrate/poses/frame_links.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace raywalk::calibrate {
namespace {

using ::testing::ElementsAre;

// `count` points that all of the frames see.
void add_shared(SeenPoints* points, const std::vector<int>& frames, int count) {
  for (int i = 0; i < count; ++i) {
    const int point = static_cast<int>(points->points_m.size());
    points->points_m.emplace_back(0, 0, 1);
    for (const int frame : frames)
      points->observations.push_back({frame, point, {0, 0, 1}, {0, 0, 0}});
  }
}

TEST(LinkedGroups, JoinsFramesThatShareEnough) {
  SeenPoints points;
  add_shared(&points, {0, 1}, 10);
  add_shared(&points, {1, 2}, 10);
  add_shared(&points, {2, 3}, 9);  // too few
  add_shared(&points, {3, 4}, 10);
  const std::vector<int> groups = linked_groups(6, points, 10);
  EXPECT_EQ(groups[0], groups[1]);
  EXPECT_EQ(groups[1], groups[2]);
  EXPECT_NE(groups[2], groups[3]);
  EXPECT_EQ(groups[3], groups[4]);
  EXPECT_EQ(groups[5], -1);
  EXPECT_EQ(largest_group(groups), groups[0]);
  EXPECT_EQ(largest_group(std::vector<int>{-1, -1}), -1);
}

TEST(LinkedGroups, CountsPointsOfManyFrames) {
  SeenPoints points;
  add_shared(&points, {0, 1, 2}, 6);
  add_shared(&points, {0, 2, 5}, 6);
  const std::vector<int> groups = linked_groups(6, points, 10);
  EXPECT_EQ(groups[0], groups[2]);  // 12 shared
  EXPECT_EQ(groups[1], -1);         // 6 with each
}

TEST(CommonPoints, CountsEachPointOnce) {
  SeenPoints points;
  add_shared(&points, {0, 1, 2, 3}, 4);
  add_shared(&points, {0, 1}, 5);
  EXPECT_EQ(common_points(points, {true, true, false, false}, {false, false, true, true}), 4);
}

TEST(Inliers, ExcludeWrongObservations) {
  RefinedPoses refined;
  add_shared(&refined.points, {0, 1}, 1);
  refined.errors_px = {0.5, 9.0};
  refined.inlier_px = 2.0;
  EXPECT_EQ(inliers_of(refined).observations.size(), 1U);
}

}  // namespace
}  // namespace raywalk::calibrate
