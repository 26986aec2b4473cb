#include "simulator/room/stations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/geometry/line_gaps.h"

namespace raywalk::simulator {
namespace {

// The detection of lines and cells used for rooms finds the planned ones, with the same names.
TEST(PlanLinesTest, PlannedGridIsDetected) {
  const GridSettings settings{.cell_side_m = 0.6, .cells_x = 3, .cells_z = 2, .spacing_mm = 100.0};
  const std::vector<PlannedLine> lines = plan_lines(settings);
  std::vector<StationPose> stations;
  for (const PlannedLine& line : lines) {
    for (const double along_m : line.along_m) {
      stations.push_back({line.id, line.position_m(along_m), ""});
    }
  }
  const Grid grid = find_grid(stations, {});
  ASSERT_EQ(grid.lines.size(), lines.size());
  EXPECT_EQ(grid.cells.size(), 6U);
  for (std::size_t i = 0; i < grid.lines.size(); ++i) {
    EXPECT_EQ(grid.lines[i].id, lines[i].id);
    EXPECT_EQ(grid.lines[i].stations.front().file, lines[i].id);
    EXPECT_NEAR(median_spacing_m(grid.lines[i]), 0.1, 1e-12);
  }
  // 25 % of 6 steps, rounded down: one step at each end.
  EXPECT_NEAR(lines[0].along_m.front(), -0.9 - 0.1, 1e-12);
}

TEST(PlanLinesTest, SpacingIsRoundedToWholeStepsAndDefaultsToAFortieth) {
  GridSettings grid;
  EXPECT_EQ(plan_lines(grid)[0].along_m.size(), 61U);
  grid.spacing_mm = 300.0;  // a cell of 1 m takes 3 steps
  grid.overhang_share = 0.0;
  EXPECT_EQ(plan_lines(grid)[0].along_m.size(), 4U);
  grid.spacing_mm = 5000.0;
  EXPECT_EQ(plan_lines(grid)[0].along_m.size(), 2U);
  grid.spacing_mm = 0.1;
  EXPECT_THROW(plan_lines(grid), UsageError);
}

TEST(PlanLinesTest, LinesMayShareTheirCrossingsOrBeASingleOne) {
  GridSettings grid{.spacing_mm = 250.0, .overhang_share = 0.0, .shared_crossings = true};
  EXPECT_EQ(plan_lines(grid)[0].along_m.size(), 5U);
  EXPECT_EQ(plan_lines(grid)[2].along_m.size(), 3U);
  grid.cells_x = 0;
  grid.cells_z = 4;
  const std::vector<PlannedLine> lines = plan_lines(grid);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].along_m.size(), 17U);
  EXPECT_EQ(lines[0].position_m(lines[0].along_m[0]), Eigen::Vector3d(0, 0, -2));
}

TEST(RoomStationsTest, StationsLieOnTheGridUnderUniqueNames) {
  VirtualRoomSettings settings;
  settings.grid.cell_side_m = 2.0;
  settings.grid.spacing_mm = 500.0;
  const auto stations = room_stations(settings);
  ASSERT_EQ(stations.size(), 4U * 7U);
  std::set<std::string> names;
  for (const RoomStation& station : stations) {
    names.insert(station.name);
    EXPECT_EQ(station.nominal.position_m.y(), 0.0);
    EXPECT_EQ(station.true_pose.position_m, station.nominal.position_m);
    EXPECT_EQ(station.true_pose.attitude.yaw_rad, 0.0);
    EXPECT_EQ(station.gain, 1.0);
  }
  EXPECT_EQ(names.size(), stations.size());
  // The back line starts at its left overhang.
  EXPECT_EQ(stations[0].name, "x0_000");
  EXPECT_EQ(stations[0].nominal.position_m, Eigen::Vector3d(-1.5, 0, -1.0));
  EXPECT_EQ(stations[6].number, 6);
}

TEST(RoomStationsTest, JitterAndGainHaveTheGivenDeviation) {
  VirtualRoomSettings settings;
  settings.grid.cells_x = settings.grid.cells_z = 4;
  settings.grid.spacing_mm = 5.0;
  settings.pose = {2.0, 0.1};
  settings.sensor.gain_spread = 0.05;
  const auto stations = room_stations(settings);
  ASSERT_GT(stations.size(), 5000U);
  double position = 0.0, attitude = 0.0, gain = 0.0, mean_gain = 0.0;
  const auto count = static_cast<double>(stations.size());
  for (const RoomStation& station : stations) {
    position +=
        (station.true_pose.position_m - station.nominal.position_m).squaredNorm() / 3.0 / count;
    const Attitude& a = station.true_pose.attitude;
    attitude +=
        (a.yaw_rad * a.yaw_rad + a.pitch_rad * a.pitch_rad + a.roll_rad * a.roll_rad) / 3.0 / count;
    gain += (station.gain - 1.0) * (station.gain - 1.0) / count;
    mean_gain += station.gain / count;
  }
  EXPECT_NEAR(std::sqrt(position), 0.002, 0.00005);
  EXPECT_NEAR(degrees_from_radians(std::sqrt(attitude)), 0.1, 0.0025);
  EXPECT_NEAR(std::sqrt(gain), 0.05, 0.002);
  EXPECT_NEAR(mean_gain, 1.0, 0.003);
}

}  // namespace
}  // namespace raywalk::simulator
