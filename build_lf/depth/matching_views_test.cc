#include "build_lf/depth/matching_views.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "build_lf/depth/depth_test_room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

std::vector<Eigen::Vector3d> positions_of(const Grid& grid) {
  std::vector<Eigen::Vector3d> positions_m;
  for (const StationIndex station : all_stations(grid)) {
    positions_m.push_back(grid.station(station).position_m);
  }
  return positions_m;
}

// Length of the component of the vector to a station that causes parallax.
double baseline_m(const MatchingGeometry& geometry, const Eigen::Vector3d& direction,
                  const Eigen::Vector3d& station_m) {
  const Eigen::Vector3d offset = station_m - geometry.reference_m;
  return (offset - offset.dot(direction) * direction).norm();
}

const std::vector<Eigen::Vector3d>& directions_around() {
  static const std::vector<Eigen::Vector3d> directions = [] {
    std::vector<Eigen::Vector3d> all;
    for (int theta_deg = -180; theta_deg < 180; theta_deg += 10) {
      for (int phi_deg = -75; phi_deg <= 75; phi_deg += 15) {
        all.push_back(direction_from_angles(
            {radians_from_degrees(theta_deg), radians_from_degrees(phi_deg)}));
      }
    }
    return all;
  }();
  return directions;
}

class MatchingViewsOfScale : public ::testing::TestWithParam<double> {
 protected:
  const double side_m_ = GetParam();
  const Grid grid_ = synthetic_grid(room_of_scale(side_m_));
  // The middle of line x0, a side of the cell.
  const MatchingGeometry geometry_{grid_.lines[0].stations[8].position_m, {1, 0, 0}, 0.5 * side_m_};
  const std::vector<Eigen::Vector3d> stations_m_ = positions_of(grid_);
};

TEST_P(MatchingViewsOfScale, LookAcrossTheRailFromEvenBaselinesOnBothSides) {
  const Eigen::Vector3d across = direction_from_angles({0.0, 0.3});
  const MatchingViews views = choose_matching_views(geometry_, across, stations_m_);
  for (const auto& side : views.side) {
    ASSERT_THAT(side, SizeIs(kViewsPerSide));
    for (int i = 0; i < kViewsPerSide; ++i) {
      EXPECT_NEAR(baseline_m(geometry_, across, stations_m_[static_cast<size_t>(side[size_t(i)])]),
                  geometry_.reach_m * (i + 1) / kViewsPerSide, 1e-9 * side_m_);
    }
  }
  const auto x_of = [&](int side) {
    return stations_m_[static_cast<size_t>(views.side[size_t(side)].front())].x();
  };
  EXPECT_LT(x_of(0) * x_of(1), 0.0);
}

TEST_P(MatchingViewsOfScale, AreDifferentStationsWithParallaxInEveryDirection) {
  for (const Eigen::Vector3d& direction : directions_around()) {
    const MatchingViews views = choose_matching_views(geometry_, direction, stations_m_);
    double longest_m = 0.0;
    std::set<int> different;
    for (const auto& side : views.side) {
      EXPECT_LE(side.size(), size_t{kViewsPerSide});
      different.insert(side.begin(), side.end());
      for (const int station : side) {
        const Eigen::Vector3d& station_m = stations_m_[static_cast<size_t>(station)];
        longest_m = std::max(longest_m, baseline_m(geometry_, direction, station_m));
        EXPECT_LE((station_m - geometry_.reference_m).dot(direction), geometry_.reach_m)
            << "may lie behind the surface";
      }
    }
    EXPECT_EQ(different.size(), views.side[0].size() + views.side[1].size());
    EXPECT_GT(longest_m, 0.5 * geometry_.reach_m) << direction.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(CellSides, MatchingViewsOfScale, ::testing::Values(0.2, 1.0, 5.0));

TEST(MatchingViewsTest, TakeCrossingLinesAlongTheRail) {
  const Grid grid = synthetic_grid(room_of_scale(1.0));
  // Near the end of line x0, the lines z0 and z1 cross it.
  const MatchingGeometry geometry{grid.lines[0].stations[14].position_m, {1, 0, 0}, 0.5};
  const Eigen::Vector3d along(-1.0, 0.0, 0.0);
  const auto stations_m = positions_of(grid);
  const MatchingViews views = choose_matching_views(geometry, along, stations_m);
  const size_t of_own_line = grid.lines[0].stations.size();
  size_t found = 0;
  for (const auto& side : views.side) {
    for (const int station : side) {
      EXPECT_GE(static_cast<size_t>(station), of_own_line);
      EXPECT_GT(baseline_m(geometry, along, stations_m[static_cast<size_t>(station)]), 0.05);
      ++found;
    }
  }
  EXPECT_GE(found, 1U);
}

TEST(MatchingViewsTest, AreNoneAlongTheRailOfASingleLine) {
  const Grid grid = synthetic_grid(line_of_scale(1.0));
  const MatchingGeometry geometry{grid.lines[0].stations[4].position_m, {1, 0, 0}, 0.5};
  for (const double x : {1.0, -1.0}) {
    const MatchingViews views = choose_matching_views(geometry, {x, 0.0, 0.0}, positions_of(grid));
    EXPECT_THAT(views.side[0], IsEmpty());
    EXPECT_THAT(views.side[1], IsEmpty());
  }
}

TEST(MatchingViewsTest, AreOnOneSideAtTheEndOfALine) {
  const Grid grid = synthetic_grid(line_of_scale(1.0));
  const MatchingGeometry geometry{grid.lines[0].stations[0].position_m, {1, 0, 0}, 0.5};
  const MatchingViews views = choose_matching_views(geometry, {0, 0, 1}, positions_of(grid));
  EXPECT_EQ(std::min(views.side[0].size(), views.side[1].size()), 0U);
  EXPECT_EQ(std::max(views.side[0].size(), views.side[1].size()), size_t{kViewsPerSide});
}

TEST(MatchingViewsTest, DoNotDependOnTheOrderOfStations) {
  Grid grid = synthetic_grid(room_of_scale(1.0));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> jitter_m(-0.02, 0.02);
  auto stations_m = positions_of(grid);
  for (auto& station : stations_m) {
    station += Eigen::Vector3d(jitter_m(random), jitter_m(random), jitter_m(random));
  }
  auto shuffled_m = stations_m;
  std::shuffle(shuffled_m.begin(), shuffled_m.end(), random);
  const MatchingGeometry geometry{{0.0, 0.0, -0.5}, {1, 0, 0}, 0.5};
  const auto chosen = [&](const auto& offered_m, const Eigen::Vector3d& direction, size_t side) {
    const MatchingViews views = choose_matching_views(geometry, direction, offered_m);
    std::vector<double> xs;
    for (const int i : views.side[side]) xs.push_back(offered_m[static_cast<size_t>(i)].x());
    return xs;
  };
  for (const Eigen::Vector3d& direction : directions_around()) {
    for (const size_t side : {0U, 1U}) {
      EXPECT_EQ(chosen(stations_m, direction, side), chosen(shuffled_m, direction, side));
    }
  }
}

}  // namespace
}  // namespace raywalk::build_lf
