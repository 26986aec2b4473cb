#include "build_lf/refine/refine_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::build_lf {
namespace {

class RefinePlanTest : public testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, directory_ / "room.lf");
    return Room::open(directory_ / "room.lf");
  }
  static int count_of(const KeptStations& kept) {
    std::size_t count = 0;
    for (const auto& line : kept) count += line.size();
    return static_cast<int>(count);
  }
  TestDirectory directory_;
};

TEST_F(RefinePlanTest, StationsWithDistancesAreDeveloped) {
  const Room room = room_of({.spacing_m = 0.0625, .width = 16, .distance_every = 4});
  const KeptStations kept = stations_to_develop(room, 0);
  for (int line = 0; line < 4; ++line) {
    const auto maps = room.distances(line).stations();
    EXPECT_TRUE(std::ranges::equal(kept[static_cast<std::size_t>(line)], maps)) << line;
  }
}

TEST_F(RefinePlanTest, ALineHasAtLeastTwo) {
  const Room room = room_of({.spacing_m = 0.125, .width = 16, .distance_every = 100});
  for (const auto& line : stations_to_develop(room, 0)) EXPECT_GE(line.size(), 2u);
}

TEST_F(RefinePlanTest, ANumberIsMetByEvenSpacing) {
  const Room room = room_of({.spacing_m = 0.03125, .width = 16, .distance_every = 4});
  for (const int asked : {8, 12, 20, 36, 60}) {
    const int count = count_of(stations_to_develop(room, asked));
    EXPECT_LE(count, asked);
    EXPECT_GT(count, asked / 2) << "the spacing is a multiple of the captured one";
  }
  EXPECT_THROW(stations_to_develop(room, -1), UsageError);
  EXPECT_THROW(stations_to_develop(room, 1000), UsageError);
}

TEST(DevelopedWidthTest, IsTwiceTheCapturedOneUnlessThatIsHuge) {
  EXPECT_EQ(developed_width({1024, 512}, 0), 2048);
  EXPECT_EQ(developed_width({1022, 511}, 0), 2044);
  EXPECT_EQ(developed_width({5760, 2880}, 0), kUsualWidth);
  EXPECT_EQ(developed_width({11520, 5760}, 0), 11520);
  EXPECT_EQ(developed_width({1024, 512}, 1024), 1024);
  for (const int asked : {1020, 2052, 1026, -4}) {
    EXPECT_THROW(developed_width({1024, 512}, asked), UsageError) << asked;
  }
}

TEST(SourcesTest, AreTheNearestAndSomeOfAllThatSeeTheSurfacesAsWell) {
  const Grid grid = synthetic_grid({.side_m = 4.0, .spacing_m = 0.0625});
  const StationIndex station{0, 30};
  const auto away_m = [&](StationIndex of) {
    return (grid.station(of).position_m - grid.station(station).position_m).norm();
  };
  const auto sources = sources_of(grid, station, 2.0);
  ASSERT_EQ(sources.size(), static_cast<std::size_t>(kMostSources));
  EXPECT_EQ(std::set(sources.begin(), sources.end()).size(), sources.size());
  double farthest_m = 0.0;
  for (const StationIndex& source : sources) {
    EXPECT_FALSE(source == station);
    EXPECT_LE(away_m(source), 2.0);
    farthest_m = std::max(farthest_m, away_m(source));
  }
  EXPECT_GT(farthest_m, 1.7);
  // The nearest 20 of a line are within 10 spacings.
  EXPECT_GE(std::ranges::count_if(
                sources, [&](StationIndex source) { return away_m(source) < 10.5 * 0.0625; }),
            20);
  // Surfaces nearer than the next station: the nearest stations all the same.
  EXPECT_EQ(sources_of(grid, station, 0.0).size(), static_cast<std::size_t>(kMostSources / 2));
}

TEST(SourcesTest, AFewStationsAreAllSources) {
  const Grid grid = synthetic_grid({.cells_z = 0, .side_m = 1.0, .spacing_m = 0.25});
  const double everywhere_m = std::numeric_limits<double>::infinity();
  EXPECT_EQ(sources_of(grid, {0, 2}, everywhere_m).size(), grid.lines[0].stations.size() - 1);
}

TEST(MedianDistanceTest, IsOfWhatIsKnown) {
  const std::vector<float> inverse{-1.0f, 0.5f, 0.25f, 0.125f, -1.0f};
  EXPECT_DOUBLE_EQ(median_distance_m(inverse), 4.0);
  EXPECT_EQ(median_distance_m({}), std::numeric_limits<double>::infinity());
  const std::vector<float> sky(5, 0.0f);
  EXPECT_EQ(median_distance_m(sky), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace raywalk::build_lf
