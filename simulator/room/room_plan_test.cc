#include "simulator/room/room_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/line_gaps.h"

namespace raywalk::capture {
namespace {

using ::testing::HasSubstr;

void expect_refused(const VirtualRoomSettings& settings, const std::string& key) {
  try {
    plan_room(settings);
    ADD_FAILURE() << key;
  } catch (const UsageError& e) {
    EXPECT_THAT(e.what(), HasSubstr(key));
  }
}

// The detection of lines and cells used for rooms finds the planned ones, with the same names.
TEST(RoomPlanTest, PlannedGridIsDetected) {
  VirtualRoomSettings settings;
  settings.grid.cells_x = 3;
  settings.grid.cells_z = 2;
  settings.grid.cell_side_m = 0.6;
  settings.grid.spacing_mm = 100.0;
  const RoomPlan plan = plan_room(settings);
  std::vector<StationPose> stations;
  for (const PlannedLine& line : plan.lines) {
    for (const double along : line.along) {
      stations.push_back({line.id, plan.unit_m * line.position(along), ""});
    }
  }
  const Grid grid = find_grid(stations, {});
  ASSERT_EQ(grid.lines.size(), plan.lines.size());
  EXPECT_EQ(grid.cells.size(), 6U);
  for (std::size_t i = 0; i < grid.lines.size(); ++i) {
    EXPECT_EQ(grid.lines[i].id, plan.lines[i].id);
    EXPECT_EQ(grid.lines[i].stations.front().file, plan.lines[i].id);
    EXPECT_NEAR(median_spacing_m(grid.lines[i]), 0.1, 1e-12);
  }
  // 25 % of 6 steps, rounded down: one step at each end.
  EXPECT_NEAR(plan.lines[0].along.front() * plan.unit_m, -0.9 - 0.1, 1e-12);
}

TEST(RoomPlanTest, SpacingIsRoundedToWholeStepsAndDefaultsToAFortieth) {
  VirtualRoomSettings settings;
  EXPECT_EQ(plan_room(settings).lines[0].along.size(), 61U);
  settings.grid.spacing_mm = 300.0;  // a cell of 1 m takes 3 steps
  settings.grid.overhang_share = 0.0;
  EXPECT_EQ(plan_room(settings).lines[0].along.size(), 4U);
  settings.grid.spacing_mm = 5000.0;
  EXPECT_EQ(plan_room(settings).lines[0].along.size(), 2U);
}

TEST(RoomPlanTest, WallsKeepTheirClearanceFromLines) {
  for (int seed = 0; seed < 200; ++seed) {
    VirtualRoomSettings settings;
    settings.seed = seed;
    settings.room.width_m = seed % 2 == 0 ? 0.0 : 2.01;
    const RoomPlan plan = plan_room(settings);
    const double reach = plan.grid_half_x() + plan.overhang + plan.clearance;
    EXPECT_LE(plan.walls.x_min, -reach + 1e-12);
    EXPECT_GE(plan.walls.x_max, reach - 1e-12);
    EXPECT_LE(plan.walls.y_min, -plan.headroom);
    EXPECT_GE(plan.walls.y_max, plan.headroom);
  }
}

TEST(RoomPlanTest, ImpossibleRoomsAreRefusedByKey) {
  VirtualRoomSettings settings;
  settings.room.width_m = 1.9;
  expect_refused(settings, "room.width_m");
  settings = {};
  settings.room.depth_m = 1.0;
  expect_refused(settings, "room.depth_m");
  settings = {};
  settings.room.height_m = 2.0;
  settings.room.camera_height_m = 1.9;
  expect_refused(settings, "room.camera_height_m");
  settings = {};
  settings.grid.spacing_mm = 0.1;
  expect_refused(settings, "grid.spacing_mm");
  settings = {};
  settings.room.furniture_scale_m = 0.009;
  expect_refused(settings, "room.furniture_scale_m");
}

}  // namespace
}  // namespace raywalk::capture
