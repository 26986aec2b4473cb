#include "render/web/web_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/base/test_error.h"
#include "core/view/test_room.h"

namespace raywalk::render {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ConnectionRule rule(double k_deg) {
  return {radians_from_degrees(k_deg), radians_from_degrees(5.0)};
}

RoomRequirements requirements(double spacing_m, double worth_width_px, int distance_width_px) {
  return {.spacing_m = spacing_m,
          .worth_width_px = worth_width_px,
          .distance_width_px = distance_width_px};
}

WebPlan plan(const Room& room, const std::optional<RoomRequirements>& required = {},
             double budget_mb = 256.0, int width_px = 0) {
  return plan_export(room, required, {budget_mb, width_px, rule(90.0)});
}

TEST(WebPlan, CountsMemoryOfPanoramasCoarseOnesAndDistances) {
  EXPECT_NEAR(gpu_mb(250, 1024, 0), 524.288 + 250 * 0.131072, 1e-9);
  EXPECT_NEAR(gpu_mb(1, 1024, 512), 2.097152 + 0.131072 + 0.262144, 1e-9);
}

TEST(WebPlan, KeepsAllWhereNothingWasMeasured) {
  const TestRoom room(box_room(96));
  const WebPlan all = plan(room.room());
  EXPECT_EQ(all.stations, 52);
  EXPECT_EQ(all.captured_stations, 52);
  EXPECT_EQ(all.width, 96);
  EXPECT_EQ(all.distance_width, 96);
  EXPECT_THAT(all.summary, HasSubstr("all 52; raywalk-build-lf require"));
}

TEST(WebPlan, HoldsWhatTheSceneRequires) {
  const TestRoom room(box_room(96));
  const WebPlan thin = plan(room.room(), requirements(0.25, 62.5, 20));
  EXPECT_THAT(thin.kept[0], ElementsAre(0, 2, 4, 6, 8, 10, 12));
  EXPECT_EQ(thin.stations, 28);
  EXPECT_EQ(thin.width, 64) << "62.5, rounded up to a multiple of 4";
  EXPECT_EQ(thin.distance_width, 20);
  EXPECT_EQ(plan(room.room(), requirements(0.25, kInfinity, 96)).width, 96);
  EXPECT_EQ(plan(room.room(), requirements(0.25, 1e9, 96)).distance_width, 96);
  EXPECT_EQ(plan(room.room(), {}, 256.0, 70).width, 68) << "asked for";
  EXPECT_EQ(plan(room.room(), {}, 256.0, 4096).width, 96) << "no more than captured";
}

TEST(WebPlan, PrefersStationsWithDistances) {
  SyntheticRoomSpec spec = box_room(32);
  spec.distance_every = 3;
  const TestRoom room(spec);
  // The ends and the corners of the cell (2 and 10) are always kept.
  EXPECT_THAT(plan(room.room(), requirements(0.4, kInfinity, 32)).kept[0],
              ElementsAre(0, 2, 3, 6, 9, 10, 12));
}

TEST(WebPlan, DistancesAreNoWiderThanTheMaps) {
  SyntheticRoomSpec spec = box_room(96);
  spec.distance_width = 24;
  EXPECT_EQ(plan(TestRoom(spec).room()).distance_width, 24);
}

TEST(WebPlan, TheBudgetReducesBothWidths) {
  const TestRoom room(box_room(512));
  const WebPlan all = plan(room.room());
  ASSERT_EQ(all.width, 512);
  const double needed_mb = gpu_mb(all.resident_stations, 512, 512);
  EXPECT_EQ(plan(room.room(), {}, 1.001 * needed_mb).width, 512);
  const WebPlan less = plan(room.room(), {}, 0.5 * needed_mb);
  EXPECT_LT(less.width, 370);
  EXPECT_GT(less.width, 310);
  EXPECT_NEAR(less.distance_width, less.width, 4);
  EXPECT_LE(gpu_mb(less.resident_stations, less.width, less.distance_width), 0.5 * needed_mb);
  EXPECT_EQ(less.stations, all.stations);
  EXPECT_THAT(less.summary, HasSubstr("hold the stations of one cell"));
}

TEST(WebPlan, ATooSmallBudgetIsToldTheLeast) {
  const TestRoom room(box_room(512));
  const std::string error = error_of([&] { plan(room.room(), {}, 1.0); });
  const auto at = error.find("need ");
  ASSERT_NE(at, std::string::npos) << error;
  const double least_mb = std::stod(error.substr(at + 5));
  EXPECT_EQ(plan(room.room(), {}, least_mb).width, 256);
  EXPECT_THAT(error_of([&] { plan(room.room(), {}, least_mb - 1.0); }), HasSubstr("--budget-mb"));
}

TEST(WebPlan, OneCellReadsOnlyTheStationsAroundIt) {
  SyntheticRoomSpec spec = box_room(32);
  spec.cells_x = spec.cells_z = 3;
  const Grid grid = synthetic_grid(spec);
  // Each of the four lines of a cell has 29 stations, 9 of them along its sides.
  const int at_90 = most_stations_of_a_cell(grid, rule(90.0));
  EXPECT_GE(at_90, 4 * 9);
  EXPECT_LE(at_90, 4 * 19) << "connected near the corners";
  EXPECT_GT(most_stations_of_a_cell(grid, rule(45.0)), at_90) << "connected beyond them";
}

TEST(WebPlan, AllStationsServeALineWithoutCells) {
  const TestRoom room({.cells_z = 0, .width = 32});
  EXPECT_EQ(plan(room.room()).resident_stations, plan(room.room()).stations);
}

}  // namespace
}  // namespace raywalk::render
