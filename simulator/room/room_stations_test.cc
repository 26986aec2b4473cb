#include "simulator/room/room_stations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace raywalk::capture {
namespace {

TEST(RoomStationsTest, StationsLieOnTheGridUnderUniqueNames) {
  VirtualRoomSettings settings;
  settings.grid.cell_side_m = 2.0;
  settings.grid.spacing_mm = 500.0;
  const auto stations = room_stations(plan_room(settings), settings);
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
  const auto stations = room_stations(plan_room(settings), settings);
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

TEST(RoomStationsTest, SeedChoosesTheJitter) {
  VirtualRoomSettings settings;
  settings.pose.position_jitter_mm = 1.0;
  const RoomPlan plan = plan_room(settings);
  const auto first = room_stations(plan, settings), again = room_stations(plan, settings);
  settings.seed = 2;
  const auto other = room_stations(plan, settings);
  EXPECT_EQ(first[5].true_pose.position_m, again[5].true_pose.position_m);
  EXPECT_NE(first[5].true_pose.position_m, other[5].true_pose.position_m);
  EXPECT_NE(first[5].noise_key, first[6].noise_key);
}

}  // namespace
}  // namespace raywalk::capture
