#include "build_lf/depth/nearest_maps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>

#include "build_lf/depth/tile_views.h"

namespace raywalk::build_lf {
namespace {

// Looks at every map.
std::vector<int> nearest_of_all(const std::vector<SweepCandidate>& maps, StationIndex station,
                                const Eigen::Vector3d& position_m, int own, int others) {
  std::vector<std::pair<double, int>> order;
  for (int i = 0; i < static_cast<int>(maps.size()); ++i) {
    const SweepCandidate& map = maps[static_cast<size_t>(i)];
    if (!(map.station == station)) order.emplace_back((map.position_m - position_m).norm(), i);
  }
  std::ranges::sort(order);
  std::vector<int> nearest;
  for (const auto& [away_m, i] : order) {
    int& open = maps[static_cast<size_t>(i)].station.line == station.line ? own : others;
    if (open-- > 0) nearest.push_back(i);
  }
  return nearest;
}

TEST(NearestMapsTest, AreThoseThatALookAtAllOfThemFinds) {
  cv::RNG random(5);
  std::vector<SweepCandidate> maps;
  for (int line = 0; line < 12; ++line) {
    // Some lines have fewer maps than are asked for; equal positions occur.
    for (int s = 0; s < (line % 3 == 0 ? 3 : 40); ++s) {
      const double along = std::round(random.uniform(0.0, 20.0) * 4.0) / 4.0;
      maps.push_back({{line, s}, {along, random.uniform(-0.02, 0.02), 0.5 * line}});
    }
  }
  for (const SweepCandidate& from : maps) {
    EXPECT_EQ(nearest_maps(maps, from.station, from.position_m, 4, 6),
              nearest_of_all(maps, from.station, from.position_m, 4, 6));
  }
  const Eigen::Vector3d outside(-30.0, 0.0, 90.0);
  EXPECT_EQ(nearest_maps(maps, {3, 99}, outside, 4, 6),
            nearest_of_all(maps, {3, 99}, outside, 4, 6));
  EXPECT_TRUE(nearest_maps(std::vector<SweepCandidate>(), {0, 0}, outside, 4, 6).empty());
}

}  // namespace
}  // namespace raywalk::build_lf
