#include "core/room/needed_stations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::ElementsAre;
using ::testing::IsSupersetOf;

constexpr double kNoLimit_m = std::numeric_limits<double>::infinity();

// A single line with stations at the given positions.
Grid line_of(const std::vector<double>& along_m) {
  Grid grid = synthetic_grid({.cells_z = 0});
  grid.lines[0].stations.clear();
  for (const double along : along_m) {
    grid.lines[0].stations.push_back({.file = {}, .position_m = {along, 0, 0}, .along_m = along});
  }
  return grid;
}

TEST(NeededStations, LeaveNoGapWiderThanTheSpacing) {
  const Grid grid = line_of({0, 1, 2, 3, 4, 5, 6, 7});
  EXPECT_THAT(needed_stations(grid, 0, 1.0, {}), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  EXPECT_THAT(needed_stations(grid, 0, 1.99, {}), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  EXPECT_THAT(needed_stations(grid, 0, 2.0, {}), ElementsAre(0, 2, 4, 6, 7));
  EXPECT_THAT(needed_stations(grid, 0, 3.0, {}), ElementsAre(0, 3, 6, 7));
  EXPECT_THAT(needed_stations(grid, 0, kNoLimit_m, {}), ElementsAre(0, 7));
}

TEST(NeededStations, AreRobustToRounding) {
  std::vector<double> along;
  for (int i = 0; i < 31; ++i) along.push_back(0.1 * i);
  EXPECT_EQ(needed_stations(line_of(along), 0, 0.3, {}).size(), 11U);
}

TEST(NeededStations, DependOnTheWidthOfGapsNotTheirNumber) {
  const Grid grid = line_of({0, 0.1, 0.2, 1.0, 3.0, 3.1, 3.2});
  EXPECT_THAT(needed_stations(grid, 0, 1.0, {}), ElementsAre(0, 3, 4, 6));
  EXPECT_THAT(needed_stations(grid, 0, 0.05, {}), ElementsAre(0, 1, 2, 3, 4, 5, 6))
      << "nothing is left out where the line is too coarse already";
}

TEST(NeededStations, StationsWithDistancesArePreferred) {
  const Grid grid = line_of({0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  EXPECT_THAT(needed_stations(grid, 0, 3.0, std::array{0, 2, 4, 6, 8}), ElementsAre(0, 2, 4, 6, 9));
  EXPECT_THAT(needed_stations(grid, 0, 3.0, std::array{4}), ElementsAre(0, 3, 4, 7, 9));
}

TEST(NeededStations, CrossingsAreKept) {
  // Cells of 1 m, lines reach 0.25 m beyond them: crossings at stations 2, 10 and 18 of 21.
  const SyntheticRoomSpec spec{
      .cells_x = 2, .cells_z = 2, .side_m = 1.0, .spacing_m = 0.125, .overhang_m = 0.25};
  const Grid grid = synthetic_grid(spec);
  for (int line = 0; line < static_cast<int>(grid.lines.size()); ++line) {
    EXPECT_THAT(needed_stations(grid, line, kNoLimit_m, {}), ElementsAre(0, 2, 10, 18, 20));
    EXPECT_THAT(needed_stations(grid, line, 0.6, {}), IsSupersetOf({0, 2, 10, 18, 20}));
  }
}

TEST(NeededStations, LineOfTwoStationsKeepsBoth) {
  EXPECT_THAT(needed_stations(line_of({0, 1}), 0, kNoLimit_m, {}), ElementsAre(0, 1));
  EXPECT_THAT(needed_stations(line_of({0, 1}), 0, 0.01, {}), ElementsAre(0, 1));
}

}  // namespace
}  // namespace raywalk
