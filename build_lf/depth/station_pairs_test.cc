#include "build_lf/depth/station_pairs.h"

#include <gmock/gmock.h>

#include <set>

#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;

// Stations connected with the first one by pairs.
std::set<StationIndex> reached(const std::vector<StationPair>& pairs) {
  std::set<StationIndex> stations{{0, 0}};
  for (size_t before = 0; before != stations.size();) {
    before = stations.size();
    for (const auto& [from, to] : pairs) {
      if (stations.count(from) + stations.count(to) == 1) stations.insert({from, to});
    }
  }
  return stations;
}

size_t station_count(const Grid& grid) {
  size_t count = 0;
  for (const Line& line : grid.lines) count += line.stations.size();
  return count;
}

TEST(StationPairsTest, AreTheNextTwoOfASingleLine) {
  const Grid grid = synthetic_grid({.cells_x = 1, .cells_z = 0, .spacing_m = 0.25});
  ASSERT_EQ(grid.lines[0].stations.size(), 5);
  const auto pair = [](int a, int b) { return StationPair{{0, a}, {0, b}}; };
  EXPECT_THAT(pairs_to_compare(grid), ElementsAre(pair(0, 1), pair(0, 2), pair(1, 2), pair(1, 3),
                                                  pair(2, 3), pair(2, 4), pair(3, 4)));
}

TEST(StationPairsTest, ConnectLinesWhereTheyCross) {
  SyntheticRoomSpec spec{.cells_x = 2, .cells_z = 1, .spacing_m = 0.25, .overhang_m = 0.25};
  const Grid grid = synthetic_grid(spec);
  const auto pairs = pairs_to_compare(grid);
  EXPECT_EQ(reached(pairs).size(), station_count(grid));
  // The lower left corner: line x0 from -1.25 m on, line z0 from -0.75 m on.
  EXPECT_THAT(pairs, Contains(StationPair{{0, 1}, {2, 1}}));
  size_t between_lines = 0;
  for (const auto& [from, to] : pairs) between_lines += from.line != to.line ? 1U : 0U;
  EXPECT_EQ(between_lines, 6);  // crossings
}

TEST(StationPairsTest, ConnectParallelLinesAtTheirNearestStations) {
  Grid grid = synthetic_grid({.cells_x = 1, .cells_z = 2, .spacing_m = 0.5});
  grid.lines.resize(3);  // those along x
  grid.lines[1].stations[2].position_m.z() -= 0.1;
  const auto pairs = pairs_to_compare(grid);
  EXPECT_EQ(reached(pairs).size(), station_count(grid));
  EXPECT_THAT(pairs, Contains(StationPair{{0, 2}, {1, 2}}));
}

}  // namespace
}  // namespace raywalk::build_lf
