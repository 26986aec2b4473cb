#include "calibrate/poses/pose_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "calibrate/poses/test_rail_scene.h"

namespace raywalk::calibrate {
namespace {

// Lines `count` x `count` with cells of 1 m that reach 0.5 m beyond, stations 0.1 m apart.
CaptureSet large_grid(int count) {
  CaptureSet set;
  set.source = "test";
  const double length_m = count;
  for (int i = 0; i < count; ++i) {
    const double across_m = i - 0.5 * (count - 1);
    add_test_line(&set, "x" + std::to_string(i), LineAxis::kX, across_m, length_m, 10 * count + 1);
    add_test_line(&set, "z" + std::to_string(i), LineAxis::kZ, across_m, length_m, 10 * count + 1);
  }
  return set;
}

std::vector<PosePart> divided(const CaptureSet& set, int most) {
  const auto crossings = crossings_of(set);
  const auto keyframes = choose_keyframes(set, crossings, 0.0);
  return divide_grid(set, crossings, keyframes, choose_pairs(set, crossings, keyframes), most);
}

TEST(PoseParts, ASmallGridIsOnePart) {
  const CaptureSet set = large_grid(2);
  const auto parts = divided(set, 84);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].home.size(), 84U);
  EXPECT_EQ(parts[0].frames, parts[0].home);
  const auto crossings = crossings_of(set);
  EXPECT_EQ(parts[0].pairs, choose_pairs(set, crossings, parts[0].home));
}

TEST(PoseParts, CutBetweenLinesAndCoverAllPairs) {
  CaptureSet set = large_grid(4);
  // A held-out frame in the lower left corner.
  set.frames.push_back({.name = "true", .line = kHeldOut, .nominal_m = {-1.4, 0.0, -1.3}});
  const auto parts = divided(set, 90);
  ASSERT_EQ(parts.size(), 4U);
  std::vector<int> homes(set.frames.size(), 0);
  std::set<FramePair> pairs;
  for (const PosePart& part : parts) {
    EXPECT_TRUE(std::is_sorted(part.home.begin(), part.home.end()));
    for (const int frame : part.home) {
      ++homes[static_cast<std::size_t>(frame)];
      // A quarter of the plan each: cut in the middle, between the lines.
      const auto& first = set.frames[static_cast<std::size_t>(part.home.front())].nominal_m;
      const auto& at = set.frames[static_cast<std::size_t>(frame)].nominal_m;
      EXPECT_LT(std::abs(at.x() - first.x()), 2.05);
      EXPECT_LT(std::abs(at.z() - first.z()), 2.05);
    }
    EXPECT_GT(part.frames.size(), part.home.size() + 15);
    EXPECT_LT(part.frames.size(), 2 * part.home.size());
    pairs.insert(part.pairs.begin(), part.pairs.end());
  }
  EXPECT_EQ(std::count(homes.begin(), homes.end(), 1), std::ssize(homes));
  const auto crossings = crossings_of(set);
  EXPECT_EQ(pairs.size(),
            choose_pairs(set, crossings, choose_keyframes(set, crossings, 0.0)).size());
}

// Two lines that nothing but a third one connects, far from where they are cut.
TEST(PoseParts, AreConnected) {
  CaptureSet set;
  set.source = "test";
  add_test_line(&set, "x0", LineAxis::kX, -0.5, 8.0, 81);
  add_test_line(&set, "x1", LineAxis::kX, 0.5, 8.0, 81);
  add_test_line(&set, "z0", LineAxis::kZ, -3.5, 2.0, 21);
  const auto parts = divided(set, 100);
  ASSERT_EQ(parts.size(), 3U);
  for (const PosePart& part : parts) {
    std::set<int> reached{part.home.front()};
    for (std::size_t last = 0; last != reached.size();) {
      last = reached.size();
      for (const FramePair& pair : part.pairs) {
        if (reached.contains(pair.first)) reached.insert(pair.second);
        if (reached.contains(pair.second)) reached.insert(pair.first);
      }
    }
    EXPECT_EQ(reached.size(), part.frames.size());
  }
}

}  // namespace
}  // namespace raywalk::calibrate
