// Which stations are matched with each other, and which of the points found are used.
#include "calibrate/poses/match_pairs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibrate/poses/seen_points.h"
#include "calibrate/poses/test_rail_scene.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;

std::vector<std::size_t> all_frames(const CaptureSet& set) {
  return choose_keyframes(set, {}, 0.0);
}

TEST(CellSide, IsTheDistanceOfNeighbouringCrossings) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    const CaptureSet set = test_grid(61, size);
    EXPECT_NEAR(cell_side_m(set, crossings_of(set)), size, 1e-9 * size);
  }
  // Without crossings it is estimated from the longest line.
  EXPECT_NEAR(cell_side_m(test_line(7, 1.5), {}), 1.0, 1e-12);
}

TEST(HeldOutFrames, AreKeyframesMatchedWithTheStationsAroundThem) {
  CaptureSet set = test_grid(61);  // 25 mm apart
  const std::vector<LineCrossing> crossings = crossings_of(set);
  const std::vector<std::size_t> before = choose_keyframes(set, crossings, 150.0);
  const std::vector<FramePair> pairs_before = choose_pairs(set, crossings, before);
  const std::size_t held_out = set.frames.size();
  set.frames.push_back({.name = "t", .line = kHeldOut, .nominal_m = {0.1, 0.0, -0.3}});
  std::vector<std::size_t> expected = before;
  expected.push_back(held_out);
  const std::vector<std::size_t> keyframes = choose_keyframes(set, crossings, 150.0);
  ASSERT_EQ(keyframes, expected);
  // The stations are matched as without it, and none but keyframes.
  std::vector<FramePair> pairs = choose_pairs(set, crossings, keyframes);
  for (const auto& [first, second] : pairs) {
    EXPECT_THAT(keyframes, AllOf(Contains(first), Contains(second)));
  }
  std::vector<std::size_t> partners;
  std::erase_if(pairs, [&](const FramePair& pair) {
    if (pair.second == held_out) partners.push_back(pair.first);
    return pair.second == held_out;
  });
  EXPECT_EQ(pairs, pairs_before);
  // x0 at z = -0.5 and z1 at x = 0.5 are nearest.
  int left = 0, right = 0;
  for (const std::size_t partner : partners) {
    const CaptureFrame& station = set.frames[partner];
    EXPECT_THAT(set.line_id(station.line), ::testing::AnyOf("x0", "z1"));
    EXPECT_LT((station.nominal_m - Eigen::Vector3d(0.1, 0.0, -0.3)).norm(), 0.5);
    if (station.line == 0) ++(station.nominal_m.x() < 0.1 ? left : right);
  }
  EXPECT_GT(left, 0);
  EXPECT_GT(right, 0);
  EXPECT_GE(partners.size(), 6U);
}

TEST(Keyframes, HaveTheRequestedSpacingAndIncludeEndsAndCrossings) {
  const CaptureSet set = test_grid(61);  // 25 mm apart; crossings at stations 10 and 50
  const std::vector<LineCrossing> crossings = crossings_of(set);
  ASSERT_EQ(crossings.size(), 4U);
  for (const double apart_mm : {25.0, 60.0, 150.0, 400.0, 5000.0}) {
    const std::vector<std::size_t> keyframes = choose_keyframes(set, crossings, apart_mm);
    EXPECT_TRUE(std::is_sorted(keyframes.begin(), keyframes.end()));
    for (int line = 0; line < 4; ++line) {
      const int first = 61 * line;
      // The crossing lies on a station: that one and the one before it, up to rounding.
      for (const int station : {0, 60}) EXPECT_THAT(keyframes, Contains(first + station));
      for (const int crossing : {10, 50}) {
        const auto close =
            std::count_if(keyframes.begin(), keyframes.end(), [&](std::size_t frame) {
              return std::abs(static_cast<int>(frame) - first - crossing) <= 1;
            });
        EXPECT_GE(close, 2);
      }
    }
    for (std::size_t i = 1; i < keyframes.size(); ++i) {
      if (keyframes[i] / 61 != keyframes[i - 1] / 61) continue;
      const double gap_mm = 1e3 * (set.rail_m(keyframes[i]) - set.rail_m(keyframes[i - 1]));
      EXPECT_LE(gap_mm, std::max(apart_mm, 25.0) * 1.01);
    }
  }
  EXPECT_EQ(choose_keyframes(set, crossings, 5000.0).size(), 4U * 6U);
}

TEST(Pairs, OfASparseLineAreTheTwoNext) {
  const CaptureSet set = test_line(5);
  EXPECT_THAT(choose_pairs(set, {}, all_frames(set)),
              ElementsAre(FramePair{0, 1}, FramePair{0, 2}, FramePair{1, 2}, FramePair{1, 3},
                          FramePair{2, 3}, FramePair{2, 4}, FramePair{3, 4}));
}

TEST(Pairs, OfADenseLineReachAQuarterOfACell) {
  const CaptureSet set = test_line(61);
  const std::vector<FramePair> pairs = choose_pairs(set, {}, all_frames(set));
  EXPECT_THAT(pairs, Contains(FramePair{10, 11}));
  EXPECT_THAT(pairs, Contains(FramePair{10, 14}));
  for (const FramePair& pair : pairs) EXPECT_LE(pair.second - pair.first, 10);
  // The last ones have no 4th and are paired with the second next.
  EXPECT_EQ(pairs.size(), 60U + 57U + 2U);
}

TEST(Pairs, CrossBetweenLinesOnlyWhereTheyCross) {
  const CaptureSet set = test_grid(61);
  const std::vector<LineCrossing> crossings = crossings_of(set);
  std::array<int, 4> across{};
  for (const FramePair& pair : choose_pairs(set, crossings, all_frames(set))) {
    const CaptureFrame& first = set.frames[pair.first];
    const CaptureFrame& second = set.frames[pair.second];
    EXPECT_LT(pair.first, pair.second);
    if (first.line == second.line) continue;
    EXPECT_NE(set.lines[first.line].axis, set.lines[second.line].axis);
    bool near_one = false;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      const Eigen::Vector3d at(crossings[i].at.x_m, 0, crossings[i].at.z_m);
      if ((first.nominal_m - at).norm() > 0.201 || (second.nominal_m - at).norm() > 0.201) continue;
      near_one = true;
      ++across[i];
    }
    EXPECT_TRUE(near_one);
  }
  EXPECT_THAT(across, ElementsAre(25, 25, 25, 25));
}

TEST(Pairs, JoinThePlacementsOfALine) {
  CaptureSet set = test_line(8);
  CaptureLine behind = set.lines[0];
  behind.id += "-2";
  behind.frames.assign(set.lines[0].frames.begin() + 5, set.lines[0].frames.end());
  set.lines[0].frames.resize(5);
  for (const int frame : behind.frames) set.frames[frame].line = 1;
  set.lines.push_back(behind);
  EXPECT_EQ(choose_pairs(set, {}, all_frames(set)),
            choose_pairs(test_line(8), {}, all_frames(test_line(8))));
  set.lines[1].across_m += 1.0;  // another line
  for (const FramePair& pair : choose_pairs(set, {}, all_frames(set))) {
    EXPECT_EQ(pair.first < 5, pair.second < 5);
  }
}

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
