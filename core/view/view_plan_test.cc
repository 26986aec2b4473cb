#include "core/view/view_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/geometry/sphere.h"
#include "core/view/test_grid.h"

namespace raywalk {
namespace {

const ConnectionRule kPhysical{kHalfPi, 0.0};
ConnectionRule rule_of(double k_deg, double overlap_deg = 5.0) {
  return {radians_from_degrees(k_deg), radians_from_degrees(overlap_deg)};
}

PlanPoint point_on(const Line& line, double along_m) {
  return {line.origin.x_m + along_m * line.direction.x_m,
          line.origin.z_m + along_m * line.direction.z_m};
}
double position_of(const Grid& grid, const RaySource& source) {
  const auto& stations = grid.lines[static_cast<size_t>(source.line)].stations;
  const auto i = static_cast<size_t>(source.station);
  return stations[i].along_m + source.fraction * (stations[i + 1].along_m - stations[i].along_m);
}
// `point` turned so that the normal of side `side` looks to +z.
PlanPoint seen_from_side(PlanPoint point, int side) {
  const double s = std::sin(side * kHalfPi);
  const double c = std::cos(side * kHalfPi);
  return {point.x_m * c - point.z_m * s, point.x_m * s + point.z_m * c};
}

class ViewPlanScale : public testing::TestWithParam<double> {};

// The crossing of the front line: A = (x + (N/2 - z) tan theta, N/2), d_p = (N/2 - z) / cos theta.
TEST_P(ViewPlanScale, CrossingHasTheClosedFormOnEverySide) {
  const double n = GetParam();
  const Grid grid = square_grid(n, n);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> place(-0.5 * n, 0.5 * n);
  std::uniform_real_distribution<double> angle(radians_from_degrees(-80.0),
                                               radians_from_degrees(80.0));
  for (int i = 0; i < 2000; ++i) {
    const int side = i % 4;
    const PlanPoint viewpoint{place(random), place(random)};
    const double theta = angle(random);
    const Line& line = grid.lines[static_cast<size_t>(side)];
    const auto crossing = cross_line(line, viewpoint, theta + side_normal_rad(Side(side)));
    ASSERT_TRUE(crossing.has_value());
    const PlanPoint p = seen_from_side(viewpoint, side);
    const PlanPoint a = seen_from_side(point_on(line, crossing->along_m), side);
    EXPECT_NEAR(crossing->d_p_m, (0.5 * n - p.z_m) / std::cos(theta), 1e-13 * n);
    EXPECT_NEAR(a.x_m, p.x_m + (0.5 * n - p.z_m) * std::tan(theta), 1e-13 * n);
    EXPECT_NEAR(a.z_m, 0.5 * n, 1e-13 * n);
  }
}

TEST_P(ViewPlanScale, EveryColumnIsReadWhereItsRayCrossesALineAndItsWeightsAddUpToOne) {
  const double n = GetParam();
  const Grid grid = square_grid(n, 0.25 * n);
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> place(-0.5 * n, 0.5 * n), k_deg(45.0, 90.0);
  for (int view = 0; view < 60; ++view) {
    const PlanPoint viewpoint{place(random), place(random)};
    const bool physical = view % 2 == 0;
    const ViewPlan plan(grid, viewpoint, physical ? kPhysical : rule_of(k_deg(random), 10.0));
    for (int i = 0; i < 360; ++i) {
      const double theta = radians_from_degrees(i - 180.0 + 0.123);
      const ColumnPlan column = plan.column(theta);
      ASSERT_GE(column.front_count, 1);
      double sum = 0.0;
      for (std::size_t s = 0; s < static_cast<std::size_t>(column.front_count); ++s) {
        const RaySource& source = column.front[s];
        ASSERT_GE(source.d_p_m, 0.0);
        ASSERT_GT(source.weight, 0.0);
        sum += source.weight;
        const double at = position_of(grid, source);
        const PlanPoint a = point_on(grid.lines[static_cast<std::size_t>(source.line)], at);
        ASSERT_NEAR(a.x_m, viewpoint.x_m + source.d_p_m * std::sin(theta), 1e-12 * n);
        ASSERT_NEAR(a.z_m, viewpoint.z_m + source.d_p_m * std::cos(theta), 1e-12 * n);
        ASSERT_LE(std::fabs(at), (physical ? 0.5 : 0.75) * n * (1.0 + 1e-12));
      }
      ASSERT_NEAR(sum, 1.0, 1e-12);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(CellSides, ViewPlanScale, testing::Values(1e-3, 1.0, 1e3));

TEST(ViewPlan, ColumnBehindIsTheOppositeColumnAtNegativeDistance) {
  const Grid grid = square_grid(1.0, 0.3);
  const ViewPlan plan(grid, {0.1, 0.3}, rule_of(76.0));
  for (int i = 0; i < 360; ++i) {
    const double theta = radians_from_degrees(i + 0.25);
    const ColumnPlan column = plan.column(theta), opposite = plan.column(theta + kPi);
    ASSERT_EQ(column.behind_count, opposite.front_count);
    for (std::size_t s = 0; s < static_cast<std::size_t>(column.behind_count); ++s) {
      const RaySource &behind = column.behind[s], &front = opposite.front[s];
      EXPECT_EQ(behind.d_p_m, -front.d_p_m);
      EXPECT_EQ(behind.line, front.line);
      EXPECT_EQ(behind.station + behind.fraction, front.station + front.fraction);
      EXPECT_EQ(behind.weight, front.weight);
    }
  }
}

TEST(ViewPlan, LfuReadsEveryLineUpTo45DegreesOffItsNormal) {
  const Grid grid = square_grid(1.0, 2.0);
  const ViewPlan plan(grid, {0.3, 0.05}, rule_of(45.0, 0.0));
  for (int i = 0; i < 360; ++i) {
    const ColumnPlan column = plan.column(radians_from_degrees(i + 0.5));
    ASSERT_EQ(column.front_count, 1);
    EXPECT_EQ(column.front[0].line, (i + 45) / 90 % 4) << i;
  }
}

TEST(ViewPlan, BlendsTwoLinesAroundAConnectionOnly) {
  const Grid grid = square_grid(1.0, 0.5);
  const ViewPlan plan(grid, {0.0, 0.0}, rule_of(90.0, 6.0));
  EXPECT_EQ(plan.column(radians_from_degrees(41.0)).front_count, 1);
  EXPECT_EQ(plan.column(radians_from_degrees(49.0)).front_count, 1);
  const ColumnPlan blended = plan.column(radians_from_degrees(43.5));
  ASSERT_EQ(blended.front_count, 2);
  EXPECT_EQ(blended.front[0].line, 0);
  EXPECT_NEAR(blended.front[0].weight, 0.75, 1e-9);
  EXPECT_EQ(blended.front[1].line, 1);
  EXPECT_NEAR(blended.front[1].weight, 0.25, 1e-9);
}

TEST(ViewPlan, ViewpointOnALineOrCornerIsReadThere) {
  const Grid grid = square_grid(1.0, 0.25);
  const ViewPlan on_line(grid, {0.13, 0.5}, kPhysical);
  for (int i = -89; i < 90; ++i) {
    const RaySource source = on_line.column(radians_from_degrees(i)).front[0];
    EXPECT_EQ(source.line, 0);
    EXPECT_EQ(source.d_p_m, 0.0);
    EXPECT_NEAR(position_of(grid, source), 0.13, 1e-15);
  }
  const ViewPlan on_corner(grid, {0.5, -0.5}, rule_of(76.0));
  for (int i = 0; i < 360; ++i) {
    const ColumnPlan column = on_corner.column(radians_from_degrees(i + 0.5));
    ASSERT_GE(column.front_count, 1);
    // Rays that leave the cell there and then are acquired at the corner itself.
    if (i < 90 || i >= 180) continue;
    EXPECT_EQ(column.front[0].d_p_m, 0.0);
    EXPECT_NEAR(std::fabs(position_of(grid, column.front[0])), 0.5, 1e-12);
  }
}

TEST(ViewPlan, CountsTheCornersThatNeedMoreOverhang) {
  // At k = 45 a viewpoint beside both diagonals needs overhang at all corners; on the diagonals at
  // none, and physical connections never do.
  const Grid bare = square_grid(1.0, 0.0);
  EXPECT_EQ(ViewPlan(bare, {0.3, 0.1}, rule_of(45.0)).limited_corners(), 4);
  EXPECT_EQ(ViewPlan(bare, {0.3, 0.1}, rule_of(90.0)).limited_corners(), 0);
  EXPECT_EQ(ViewPlan(square_grid(1.0, 1.0), {0.3, 0.1}, rule_of(45.0)).limited_corners(), 0);
}

TEST(ViewPlan, OutsideOfEveryCellNamesTheNearestPlaceInside) {
  const Grid grid = square_grid(1.0003, 0.0);
  const auto error_at = [&](PlanPoint at) {
    return error_of([&] { ViewPlan(grid, at, kPhysical); });
  };
  EXPECT_THAT(error_at({0.7, 0.25}), testing::HasSubstr("the nearest is 0.5,0.25 ("));
  EXPECT_THAT(error_at({-500.0, 1000.0}), testing::HasSubstr("the nearest is -0.5,0.5 ("));
}

TEST(LineCrossing, LiesOnTheRayAndOnAnObliqueLineUnlessParallel) {
  EXPECT_FALSE(cross_line(line_at(LineAxis::kZ, 0.5, {-1.0, 1.0}), {0.2, 0.0}, 0.0));
  Line line = line_at(LineAxis::kX, 0.5, {-1.0, 0.0, 1.0});
  line.direction = {std::cos(0.03), std::sin(0.03)};
  for (const double theta : {-1.2, -0.2, 0.0, 0.6, 1.4}) {
    const auto crossing = cross_line(line, {0.2, -0.3}, theta);
    ASSERT_TRUE(crossing.has_value());
    const PlanPoint a = point_on(line, crossing->along_m);
    EXPECT_NEAR(a.x_m, 0.2 + crossing->d_p_m * std::sin(theta), 1e-14);
    EXPECT_NEAR(a.z_m, -0.3 + crossing->d_p_m * std::cos(theta), 1e-14);
  }
}

TEST(RaySource, InterpolatesBetweenIrregularStationsAndEndsWithTheLine) {
  const Line line = line_at(LineAxis::kX, 0.0, {-1.0, -0.9, 0.3, 0.35, 2.0});
  const struct {
    double along_m;
    int station;
    double fraction;
  } cases[] = {{-0.95, 0, 0.5}, {0.0, 1, 0.75}, {0.3, 2, 0.0}, {1.175, 3, 0.5},
               {-5.0, 0, 0.0},  {2.0, 3, 1.0},  {5.0, 3, 1.0}};
  for (const auto& c : cases) {
    const RaySource source = source_at(line, 7, {0.4, c.along_m});
    EXPECT_EQ(source.line, 7);
    EXPECT_EQ(source.d_p_m, 0.4);
    EXPECT_EQ(source.station, c.station) << c.along_m;
    EXPECT_NEAR(source.fraction, c.fraction, 1e-12) << c.along_m;
  }
}

// A single line is the paper's 3D360: no cell, but the views its captured part is seen in.
TEST(OpenGrid, ALineServesTheColumnsWhoseRaysCrossItAndTheNearerOneIsRead) {
  Grid grid;
  const std::vector<double> stations{-1.0, -0.5, 0.0, 0.5, 1.0};
  grid.lines = {line_at(LineAxis::kX, 2.0, {-0.1, 0.1}), line_at(LineAxis::kX, 1.0, stations)};
  const ViewPlan ahead(grid, {0.0, 0.0}, kPhysical);  // sees it under -45..45 degrees
  const ViewPlan on_it(grid, {0.25, 1.0}, kPhysical);
  for (int i = -180; i < 180; ++i) {
    const double theta = radians_from_degrees(i + 0.5);
    const ColumnPlan column = ahead.column(theta);
    const bool seen = i >= -45 && i < 45;
    ASSERT_EQ(column.front_count, seen ? 1 : 0) << i;
    if (seen) {
      EXPECT_EQ(column.front[0].line, 1);
      EXPECT_NEAR(column.front[0].d_p_m, 1.0 / std::cos(theta), 1e-12);
    }
    ASSERT_EQ(on_it.column(theta).front_count, 1);
    EXPECT_EQ(on_it.column(theta).front[0].d_p_m, 0.0);
    EXPECT_NEAR(position_of(grid, on_it.column(theta).front[0]), 0.25, 1e-12);
  }
  grid.lines.erase(grid.lines.begin());
  EXPECT_THROW(ViewPlan(grid, {3.0, 1.0}, kPhysical), Error) << "nothing of it is seen there";
}

}  // namespace
}  // namespace raywalk
