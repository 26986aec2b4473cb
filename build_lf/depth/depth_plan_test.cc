#include "build_lf/depth/depth_plan.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <tuple>

#include "build_lf/depth/depth_test_room.h"
#include "core/base/error.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::ThrowsMessage;

// Plans depend only on positions and sizes, so the frames have the minimum size.
SyntheticRoomSpec tiny_room(double scale, int cells_x = 1, int cells_z = 1) {
  SyntheticRoomSpec spec = room_of_scale(scale);
  spec.cells_x = cells_x;
  spec.cells_z = cells_z;
  spec.width = 32;
  return spec;
}

// A grid of lines along x at `rows_m` and along z at `columns_m`, with a station at every
// intersection and `between` more between intersections.
Grid grid_of(const std::vector<double>& columns_m, const std::vector<double>& rows_m, int between) {
  std::vector<StationPose> poses;
  const auto add_line = [&](const std::vector<double>& along_m, double across_m, bool along_x) {
    for (size_t i = 0; i + 1 < along_m.size(); ++i) {
      const int first = i == 0 ? 0 : 1;
      for (int k = first; k <= between + 1; ++k) {
        const double at_m = along_m[i] + (along_m[i + 1] - along_m[i]) * k / (between + 1);
        poses.push_back(
            {fmt::format("{}.png", poses.size()),
             along_x ? Eigen::Vector3d(at_m, 0.0, across_m) : Eigen::Vector3d(across_m, 0.0, at_m),
             ""});
      }
    }
  };
  for (const double row_m : rows_m) add_line(columns_m, row_m, true);
  for (const double column_m : columns_m) add_line(rows_m, column_m, false);
  return find_grid(poses, {});
}

// Positions of the stations with maps on a line.
std::vector<double> map_places_m(const DepthPlan& plan, const Grid& grid, int line) {
  std::vector<double> places_m;
  for (const SweepReference& map : plan.maps) {
    if (map.station.line == line) places_m.push_back(grid.station(map.station).along_m);
  }
  return places_m;
}

template <typename Of>
std::vector<StationIndex> stations_of(const std::vector<Of>& all) {
  std::vector<StationIndex> stations;
  for (const Of& one : all) stations.push_back(one.station);
  return stations;
}

TEST(DepthPlanTest, IsInvariantToScale) {
  const DepthTestRoom metre(tiny_room(1.0, 2, 1));
  const DepthPlan of_metre = plan_depth(metre.room(), {});
  EXPECT_DOUBLE_EQ(of_metre.reach_m, 0.5);
  for (const double scale : {0.2, 0.7, 5.0}) {
    const DepthTestRoom scaled(tiny_room(scale, 2, 1));
    const DepthPlan plan = plan_depth(scaled.room(), {});
    EXPECT_NEAR(plan.reach_m, 0.5 * scale, 1e-12 * scale);
    EXPECT_EQ(stations_of(plan.maps), stations_of(of_metre.maps)) << scale;
    EXPECT_EQ(stations_of(plan.candidates), stations_of(of_metre.candidates)) << scale;
  }
}

TEST(DepthPlanTest, SmallestCellSetsTheReachHoweverNearSurfacesAre) {
  const Grid grid = grid_of({0.0, 1.0, 1.4}, {0.0, 1.0}, 9);
  const DepthTestRoom room(tiny_room(1.0), grid, nullptr);
  ASSERT_THAT(room.grid().cells, SizeIs(2));
  EXPECT_NEAR(plan_depth(room.room(), {}).reach_m, 0.2, 1e-9);
  EXPECT_NEAR(plan_depth(room.room(), {}, 1e-3).reach_m, 0.2, 1e-9);
}

// Without cells: tan(30 degrees) times the distance of near surfaces, at least the usual gap
// between neighbours, at most a quarter of the line.
TEST(DepthPlanTest, NearSurfacesShortenTheReachOfASingleLine) {
  const DepthTestRoom room(tiny_room(2.0, 1, 0));
  const double gap_m = 2.0 * 0.0625;
  const auto reach_m = [&](double surfaces_m) {
    return plan_depth(room.room(), {}, surfaces_m).reach_m;
  };
  EXPECT_NEAR(plan_depth(room.room(), {}).reach_m, 0.5, 1e-12);
  EXPECT_NEAR(reach_m(1e8), 0.5, 1e-12);
  EXPECT_NEAR(reach_m(0.6), 0.6 / std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(reach_m(1e-6), gap_m, 1e-9);
  const std::size_t maps = plan_depth(room.room(), {}).maps.size();
  EXPECT_GE(maps, 2U);
  EXPECT_GT(plan_depth(room.room(), {}, 0.3).maps.size(), maps);
}

// With irregular stations, no point of a line is too far from a map, and no two maps are needlessly
// close.
TEST(DepthPlanTest, SpreadsMapsOverIrregularStations) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> exponent(-3.0, -0.7);
    SyntheticRoomSpec spec = tiny_room(1.0);
    Grid grid = synthetic_grid(spec);
    for (Line& line : grid.lines) {
      Station station = line.stations.front();
      const double end_m = line.last_m();
      line.stations = {station};
      while (station.along_m < end_m) {
        const double step_m = std::pow(10.0, exponent(random));
        station.along_m += step_m;
        station.position_m += step_m * Eigen::Vector3d(line.direction.x_m, 0, line.direction.z_m);
        line.stations.push_back(station);
      }
    }
    const DepthTestRoom room(spec, grid, nullptr);
    const DepthPlan plan = plan_depth(room.room(), {});
    const double gap_m = 0.4 * plan.reach_m;
    for (int l = 0; l < 4; ++l) {
      const Line& line = room.grid().lines[l];
      const std::vector<double> maps_m = map_places_m(plan, room.grid(), l);
      EXPECT_EQ(maps_m.front(), line.first_m());
      EXPECT_LE(line.last_m() - maps_m.back(), 0.5 * gap_m);
      for (size_t i = 1; i < maps_m.size(); ++i) {
        EXPECT_GT(maps_m[i] - maps_m[i - 1], 0.5 * gap_m);
        // The first station after the gap was selected.
        const auto between = [&](const Station& station) {
          return station.along_m >= maps_m[i - 1] + 1.001 * gap_m && station.along_m < maps_m[i];
        };
        EXPECT_FALSE(std::ranges::any_of(line.stations, between));
      }
    }
  }
}

TEST(DepthPlanTest, EveryNthStationGetsAMapWhenAsked) {
  const DepthTestRoom room(tiny_room(1.0));  // 17 stations per line
  for (const auto& [every, maps] : {std::pair{1, 17}, {3, 6}, {16, 2}, {17, 1}, {1000000, 1}}) {
    const DepthPlan plan = plan_depth(room.room(), {.every = every});
    EXPECT_THAT(plan.maps, SizeIs(static_cast<size_t>(4 * maps))) << every;
    // The candidates are not thinned with the maps.
    EXPECT_THAT(plan.candidates, SizeIs(4 * 17U));
  }
}

TEST(DepthPlanTest, MapsAreAsWideAsAskedOrAsThePanoramasAllow) {
  const auto size_of = [](int captured, int asked) {
    SyntheticRoomSpec spec = tiny_room(1.0);
    spec.width = captured;
    return plan_depth(DepthTestRoom(spec).room(), {.width = asked}).size;
  };
  for (const auto& [captured, asked, width] :
       {std::tuple{64, 36, 36}, {64, 0, 64}, {32, 0, 32}, {34, 0, 32}, {50, 0, 48}, {52, 0, 52}}) {
    EXPECT_EQ(size_of(captured, asked), (PanoramaSize{width, width / 2}));
  }
  for (const int asked : {-4, 7, 16, 34, 68, 1 << 30}) {
    EXPECT_THAT([&] { size_of(64, asked); },
                ThrowsMessage<UsageError>(HasSubstr("multiple of 4 from 32 to 64")))
        << asked;
  }
  EXPECT_THAT([&] { size_of(16, 0); },
              ThrowsMessage<Error>(HasSubstr("panoramas of 16 x 8 are too small")));
}

TEST(DepthPlanTest, StationsLeftOutAreNeitherMappedNorCompared) {
  const DepthTestRoom room(tiny_room(1.0));
  DepthPlan plan = plan_depth(room.room(), {.every = 2});
  const DepthPlan whole = plan;
  const std::vector<StationIndex> bad{{0, 4}, {2, 5}};
  exclude_stations(bad, &plan);
  EXPECT_EQ(plan.maps.size(), whole.maps.size() - 1);
  EXPECT_EQ(plan.candidates.size(), whole.candidates.size() - 2);
  for (const StationIndex station : bad) {
    EXPECT_THAT(stations_of(plan.maps), ::testing::Not(::testing::Contains(station)));
    EXPECT_THAT(stations_of(plan.candidates), ::testing::Not(::testing::Contains(station)));
  }
}

// Candidates are thinned; a map may be at a station that is not a candidate.
TEST(DepthPlanTest, NothingLeftToCompareAndNoMapLeftAreErrors) {
  const DepthTestRoom room(tiny_room(1.0));
  DepthPlan plan = plan_depth(room.room(), {});
  std::vector<StationIndex> all_but_first = stations_of(plan.candidates);
  std::erase_if(all_but_first, [](StationIndex station) { return station.station == 0; });
  EXPECT_THAT([&] { exclude_stations(all_but_first, &plan); },
              ThrowsMessage<Error>(HasSubstr("64 of 68 stations had to be left out")));
  plan = plan_depth(room.room(), {.every = 1000});
  EXPECT_THAT([&] { exclude_stations(stations_of(plan.maps), &plan); },
              ThrowsMessage<Error>(HasSubstr("--every")));
}

class DepthVotersTest : public ::testing::Test {
 protected:
  int maps() const { return static_cast<int>(plan_.maps.size()); }
  double distance_m(int a, int b) const {
    return (plan_.maps[a].position_m - plan_.maps[b].position_m).norm();
  }

  const DepthTestRoom room_{tiny_room(1.0, 3, 2)};
  const DepthPlan plan_ = plan_depth(room_.room(), {});
};

TEST_F(DepthVotersTest, AreTheNearestMaps) {
  for (int which = 0; which < maps(); ++which) {
    const std::vector<int> voters = voters_of(plan_, which);
    EXPECT_EQ(voters.front(), which);
    EXPECT_EQ(std::set<int>(voters.begin(), voters.end()).size(), voters.size());
    const auto is_own = [&](int i) {
      return plan_.maps[i].station.line == plan_.maps[which].station.line;
    };
    EXPECT_EQ(std::ranges::count_if(voters, is_own), 1 + 4);
    EXPECT_EQ(voters.size(), 1U + 4U + 8U);
    // Maps that do not vote are at least as far away as those of the same kind that do.
    for (const bool of_own_line : {true, false}) {
      double farthest_m = 0.0;
      for (const int i : voters) {
        if (is_own(i) == of_own_line) farthest_m = std::max(farthest_m, distance_m(i, which));
      }
      for (int i = 0; i < maps(); ++i) {
        if (is_own(i) != of_own_line || std::ranges::count(voters, i) > 0) continue;
        EXPECT_GE(distance_m(i, which), farthest_m);
      }
    }
  }
}

TEST(DepthPlanTest, FewMapsAllVoteAndLeaveNoFallback) {
  const DepthTestRoom room(tiny_room(1.0, 1, 0));
  const DepthPlan plan = plan_depth(room.room(), {.every = 8});
  const std::vector<int> voters = voters_of(plan, 1);
  EXPECT_THAT(voters, ::testing::ElementsAre(1, 0, 2));
  EXPECT_TRUE(fallback_voters_of(plan, voters).empty());
}

TEST(DepthPlanTest, StationsFarAwayAreNotCompared) {
  const DepthTestRoom room(tiny_room(1.0, 3, 1));
  const DepthPlan plan = plan_depth(room.room(), {});
  const SweepReference& reference = plan.maps.front();
  const std::vector<SweepCandidate> near = candidates_near(plan, reference);
  const auto is_near = [&](const SweepCandidate& candidate) {
    return (candidate.position_m - reference.position_m).norm() <= 1.5 &&
           candidate.station != reference.station;
  };
  EXPECT_THAT(near, SizeIs(std::ranges::count_if(plan.candidates, is_near)));
  EXPECT_LT(near.size(), plan.candidates.size() - 1);
  for (const SweepCandidate& candidate : near) EXPECT_NE(candidate.station, reference.station);
}

TEST_F(DepthVotersTest, SpreadOverTheRoomAsAFallback) {
  for (int which = 0; which < maps(); ++which) {
    const std::vector<int> near = voters_of(plan_, which);
    const std::vector<int> farther = fallback_voters_of(plan_, near);
    EXPECT_GT(farther.size(), 0U);
    EXPECT_LE(farther.size(), 8U);
    for (size_t i = 0; i < farther.size(); ++i) {
      EXPECT_EQ(std::ranges::count(near, farther[i]), 0);
      for (const int other : near) {
        EXPECT_GE(distance_m(farther[i], other), 0.25 * distance_m(farther[i], which));
      }
      for (size_t j = 0; j < i; ++j) {
        EXPECT_GE(distance_m(farther[i], farther[j]), 0.25 * distance_m(farther[i], which));
        EXPECT_GE(distance_m(farther[i], which), distance_m(farther[j], which));
      }
    }
  }
}

}  // namespace
}  // namespace raywalk::build_lf
