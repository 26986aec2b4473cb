#include "core/room/kept_stations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsSupersetOf;
using ::testing::SizeIs;

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

// Lines of nine stations, maps at every second one.
class KeptStationsTest : public ::testing::Test {
 protected:
  KeptStationsTest() {
    SyntheticRoomSpec spec;
    spec.width = 16;
    spec.distance_every = 2;
    write_synthetic_room(spec, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
  }
  TestDirectory directory_;
  Room room_;
};

TEST_F(KeptStationsTest, HeldOutAndKeptStationsPartitionTheRoom) {
  for (int every = 2; every < 12; ++every) {
    const auto left_out = held_out_stations(room_.grid(), every);
    const KeptStations kept = stations_except(room_.grid(), left_out);
    for (std::size_t line = 0; line < kept.size(); ++line) {
      std::vector<int> all;
      std::ranges::merge(kept[line], left_out[line], std::back_inserter(all));
      EXPECT_THAT(all, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
      EXPECT_EQ(kept[line].front(), 0);
      EXPECT_EQ(kept[line].back(), 8);
      for (std::size_t i = 1; i < left_out[line].size(); ++i) {
        EXPECT_EQ(left_out[line][i] - left_out[line][i - 1], every);
      }
    }
  }
  EXPECT_THAT(held_out_stations(room_.grid(), 4), Each(ElementsAre(2, 6)));
}

TEST_F(KeptStationsTest, SubsetHasTheSameRaysAndMaps) {
  const std::vector<int> kept{0, 3, 4, 8};
  const Room part = room_.subset({kept, kept, kept, kept});
  // A part of a part counts from its own stations.
  const Room smaller = part.subset({{0, 2}, {0, 2}, {0, 2}, {0, 2}});
  for (int line = 0; line < 4; ++line) {
    const auto at = static_cast<std::size_t>(line);
    ASSERT_THAT(part.grid().lines[at].stations, SizeIs(4));
    ASSERT_EQ(part.volume(line).stations(), 4);
    for (int i = 0; i < 4; ++i) {
      const int whole = kept[static_cast<std::size_t>(i)];
      EXPECT_EQ(part.volume(line).column(i, 5).data(), room_.volume(line).column(whole, 5).data());
      EXPECT_EQ(part.grid().lines[at].stations[static_cast<std::size_t>(i)].file,
                room_.grid().lines[at].stations[static_cast<std::size_t>(whole)].file);
    }
    EXPECT_THAT(part.distances(line).stations(), ElementsAre(0, 2, 3));
    EXPECT_EQ(part.distances(line).distance_column(1, 7).data(),
              room_.distances(line).distance_column(2, 7).data());
    EXPECT_EQ(part.distances(line).confidence_column(2, 7).data(),
              room_.distances(line).confidence_column(4, 7).data());
    EXPECT_EQ(smaller.volume(line).column(1, 3).data(), room_.volume(line).column(4, 3).data());
    EXPECT_THAT(smaller.distances(line).stations(), ElementsAre(0, 1));
    EXPECT_EQ(smaller.distances(line).distance_column(1, 0).data(),
              room_.distances(line).distance_column(2, 0).data());
  }
  EXPECT_EQ(part.grid().cells.size(), 1U);
}

TEST_F(KeptStationsTest, InvalidSubsetsAreRejected) {
  const std::vector<int> two{0, 8};
  EXPECT_NO_THROW(room_.subset({two, two, two, two}));
  EXPECT_THROW(room_.subset({two, two, two}), UsageError);
  EXPECT_THROW(room_.subset({two, two, two, {3}}), UsageError);
  EXPECT_THROW(room_.subset({two, two, two, {3, 3}}), UsageError);
  EXPECT_THROW(room_.subset({two, two, two, {8, 0}}), UsageError);
  EXPECT_THROW(room_.subset({two, two, two, {0, 9}}), UsageError);
  EXPECT_THROW(room_.subset({two, two, two, {-1, 8}}), UsageError);
}

TEST_F(KeptStationsTest, WithDistancesReplacesTheMaps) {
  SyntheticRoomSpec spec;
  spec.width = 16;
  spec.distance_every = 4;
  write_synthetic_room(spec, directory_ / "other.lf");
  const Room room =
      room_.with_distances(distances_directory(directory_ / "other.lf", DistanceKind::kGiven));
  EXPECT_THAT(room.distances(0).stations(), ElementsAre(0, 4, 8));
  EXPECT_EQ(room.volume(2).column(8, 1).data(), room_.volume(2).column(8, 1).data());
  EXPECT_THROW(room_.with_distances(directory_ / "nowhere"), Error);
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
