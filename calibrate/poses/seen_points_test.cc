#include "calibrate/poses/seen_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "calibrate/poses/test_rail_scene.h"

namespace raywalk::calibrate {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

TEST(SeenPoints, KeepsPointsOfEnoughFrames) {
  SeenPoints points;
  points.points_m = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  // The second is seen twice by the same frame, which counts as one.
  points.observations = {{0, 0, {0, 0, 1}, {0, 0, 0}}, {1, 0, {0, 0, 1}, {0, 0, 0}},
                         {2, 1, {0, 0, 1}, {0, 0, 0}}, {2, 1, {0, 0, 1}, {0, 0, 0}},
                         {0, 2, {0, 0, 1}, {0, 0, 0}}, {2, 2, {0, 0, 1}, {0, 0, 0}}};
  const SeenPoints kept = widely_seen(points, 2);
  ASSERT_EQ(kept.points_m.size(), 2U);
  EXPECT_EQ(kept.points_m[1].x(), 3.0);
  ASSERT_EQ(kept.observations.size(), 4U);
  EXPECT_EQ(kept.observations[3].point, 1);
}

TEST(SeenPoints, StrongestGivesEveryFrameItsShareOfLongTracks) {
  const CaptureSet set = test_grid(5);
  const FramePoses truth = test_truth(set, {}, 30);
  SeenPoints points = test_points(set, truth, 2000, 1.0, 0.1, 31);
  // Half of the points are seen only twice.
  std::erase_if(points.observations,
                [last = ~std::size_t{0}, count = 0](const PointObservation& one) mutable {
                  count = one.point == last ? count + 1 : 1;
                  last = one.point;
                  return one.point % 2 == 1 && count > 2;
                });
  const SeenPoints kept = strongest(points, 50);
  std::vector<int> seen(set.frames.size(), 0);
  std::vector<int> length(kept.points_m.size(), 0);
  for (const PointObservation& observation : kept.observations) {
    ++seen[observation.frame];
    ++length[observation.point];
  }
  EXPECT_GE(*std::min_element(seen.begin(), seen.end()), 50);
  EXPECT_LT(kept.points_m.size(), 600U);
  EXPECT_GE(*std::min_element(length.begin(), length.end()), 8);
  EXPECT_EQ(strongest(points, 1000000).observations.size(), points.observations.size());
}

// `count` points that all of the frames see.
void add_shared(SeenPoints* points, const std::vector<std::size_t>& frames, int count) {
  for (int i = 0; i < count; ++i) {
    const std::size_t point = points->points_m.size();
    points->points_m.emplace_back(0, 0, 1);
    for (const std::size_t frame : frames) points->observations.push_back({frame, point});
  }
}

TEST(LinkedGroup, HasTheFramesThatShareEnough) {
  SeenPoints points;
  add_shared(&points, {0, 1}, 10);
  add_shared(&points, {1, 2}, 10);
  add_shared(&points, {2, 3}, 9);  // too few
  add_shared(&points, {3, 4}, 10);
  EXPECT_THAT(largest_linked_group(6, points, 10),
              ElementsAre(true, true, true, false, false, false));
  EXPECT_THAT(largest_linked_group(6, points, 11), Each(false));
}

TEST(LinkedGroup, CountsPointsOfManyFrames) {
  SeenPoints points;
  add_shared(&points, {0, 1, 2}, 6);
  add_shared(&points, {0, 2, 5}, 6);
  // 0 and 2 share 12, 1 shares 6 with each.
  EXPECT_THAT(largest_linked_group(6, points, 10),
              ElementsAre(true, false, true, false, false, false));
}

}  // namespace
}  // namespace raywalk::calibrate
