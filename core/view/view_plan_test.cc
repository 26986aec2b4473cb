#include "core/view/view_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/sphere.h"
#include "core/view/test_grid.h"

namespace raywalk {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

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

TEST_P(ViewPlanScale, EveryColumnIsReadWhereItsRayCrossesTheLineOfItsSide) {
  const double n = GetParam();
  const Grid grid = square_grid(n, 0.25 * n);
  const PlanPoint viewpoint{0.17 * n, -0.21 * n};
  const ViewPlan plan(grid, viewpoint, kPhysical);
  for (int i = 0; i < 720; ++i) {
    const double theta = radians_from_degrees(0.5 * i - 180.0 + 0.123);
    const ColumnPlan column = plan.column(theta);
    ASSERT_EQ(column.front_count, 1);
    const RaySource& source = column.front[0];
    ASSERT_GE(source.d_p_m, 0.0);
    const double at = position_of(grid, source);
    const PlanPoint a = point_on(grid.lines[static_cast<size_t>(source.line)], at);
    EXPECT_NEAR(a.x_m, viewpoint.x_m + source.d_p_m * std::sin(theta), 1e-12 * n);
    EXPECT_NEAR(a.z_m, viewpoint.z_m + source.d_p_m * std::cos(theta), 1e-12 * n);
    EXPECT_LE(std::fabs(at), 0.5 * n * (1.0 + 1e-12)) << "physical: within the cell's side";
  }
}

INSTANTIATE_TEST_SUITE_P(CellSides, ViewPlanScale, testing::Values(1e-3, 1.0, 1e3));

TEST(ViewPlan, ColumnBehindIsTheOppositeColumnAtNegativeDistance) {
  const Grid grid = square_grid(1.0, 0.3);
  const ViewPlan plan(grid, {0.1, 0.3}, rule_of(76.0));
  for (int i = 0; i < 360; ++i) {
    const double theta = radians_from_degrees(i + 0.25);
    const ColumnPlan column = plan.column(theta);
    const ColumnPlan opposite = plan.column(theta + kPi);
    ASSERT_EQ(column.behind_count, opposite.front_count);
    for (int s = 0; s < column.behind_count; ++s) {
      const RaySource& behind = column.behind[static_cast<size_t>(s)];
      const RaySource& front = opposite.front[static_cast<size_t>(s)];
      EXPECT_EQ(behind.d_p_m, -front.d_p_m);
      EXPECT_LE(behind.d_p_m, 0.0);
      EXPECT_EQ(behind.line, front.line);
      EXPECT_EQ(behind.station, front.station);
      EXPECT_EQ(behind.fraction, front.fraction);
      EXPECT_EQ(behind.weight, front.weight);
    }
  }
}

TEST(ViewPlanProperty, WeightsOfEveryColumnAddUpToOne) {
  const Grid grid = square_grid(1.0, 0.25);
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::uniform_real_distribution<double> k_deg(45.0, 90.0);
  for (int view = 0; view < 200; ++view) {
    const ViewPlan plan(grid, {place(random), place(random)}, rule_of(k_deg(random), 10.0));
    for (int i = 0; i < 360; ++i) {
      const ColumnPlan column = plan.column(radians_from_degrees(i - 180.0));
      ASSERT_GE(column.front_count, 1);
      double sum = 0.0;
      for (int s = 0; s < column.front_count; ++s) {
        const RaySource& source = column.front[static_cast<size_t>(s)];
        ASSERT_GT(source.weight, 0.0);
        ASSERT_GE(source.d_p_m, 0.0);
        ASSERT_GE(source.fraction, 0.0);
        ASSERT_LE(source.fraction, 1.0);
        sum += source.weight;
      }
      ASSERT_NEAR(sum, 1.0, 1e-12);
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

TEST(ViewPlan, ViewpointOnALineReadsItAtTheViewpoint) {
  const Grid grid = square_grid(1.0, 0.25);
  const ViewPlan plan(grid, {0.13, 0.5}, kPhysical);
  for (int i = -89; i < 90; ++i) {
    const ColumnPlan column = plan.column(radians_from_degrees(i));
    ASSERT_EQ(column.front_count, 1);
    EXPECT_EQ(column.front[0].line, 0);
    EXPECT_EQ(column.front[0].d_p_m, 0.0);
    EXPECT_NEAR(position_of(grid, column.front[0]), 0.13, 1e-15);
  }
}

TEST(ViewPlan, ViewpointOnACornerReadsTheCornerAllAround) {
  const Grid grid = square_grid(1.0, 0.25);
  for (const PlanPoint corner : {PlanPoint{0.5, 0.5}, {0.5, -0.5}, {-0.5, -0.5}, {-0.5, 0.5}}) {
    for (const double k_deg : {45.0, 76.0, 90.0}) {
      const ViewPlan plan(grid, corner, rule_of(k_deg));
      for (int i = 0; i < 360; ++i) {
        const double theta = radians_from_degrees(i + 0.5);
        const ColumnPlan column = plan.column(theta);
        ASSERT_GE(column.front_count, 1);
        // Rays that leave the cell there and then are acquired at the corner itself.
        const bool leaves =
            std::sin(theta) * corner.x_m > 0.0 && std::cos(theta) * corner.z_m > 0.0;
        for (int s = 0; leaves && s < column.front_count; ++s) {
          const RaySource& source = column.front[static_cast<size_t>(s)];
          EXPECT_EQ(source.d_p_m, 0.0);
          EXPECT_NEAR(std::fabs(position_of(grid, source)), 0.5, 1e-12);
        }
      }
    }
  }
}

TEST(ViewPlan, ViewpointOutsideEveryCellIsAnErrorThatNamesIt) {
  const Grid grid = square_grid(1.0, 0.25);
  EXPECT_THAT(
      [&] {
        ViewPlan(grid, {0.625, 0.0}, kPhysical);
      },
      ThrowsMessage<Error>(HasSubstr("0.625,0 m is outside")));
  EXPECT_THROW(ViewPlan(grid, {0.0, std::nan("")}, kPhysical), Error);
}

TEST(ViewPlan, HeightIsTheMeanOfTheLinesThatServe) {
  Grid grid = square_grid(1.0, 0.25);
  const auto set_height = [](Line& line, double height_m) {
    line.height_m = height_m;
    for (Station& station : line.stations) station.position_m.y() = height_m;
  };
  set_height(grid.lines[0], 0.04);
  set_height(grid.lines[2], -0.08);
  EXPECT_NEAR(ViewPlan(grid, {0.0, 0.0}, kPhysical).height_m(), -0.01, 1e-15);
}

TEST(ViewPlan, CountsTheCornersThatNeedMoreOverhang) {
  // At k = 45 a viewpoint beside both diagonals needs overhang at all corners; on the diagonals at
  // none, and physical connections never do.
  const Grid bare = square_grid(1.0, 0.0);
  EXPECT_EQ(ViewPlan(bare, {0.3, 0.1}, rule_of(45.0)).limited_corners(), 4);
  EXPECT_EQ(ViewPlan(bare, {0.3, 0.1}, rule_of(90.0)).limited_corners(), 0);
  EXPECT_EQ(ViewPlan(square_grid(1.0, 1.0), {0.3, 0.1}, rule_of(45.0)).limited_corners(), 0);
}

TEST(ViewPlan, CornerViewMeasuresFromTheViewpointAndTheLines) {
  Grid grid = square_grid(2.0, 0.5);
  // The right line ends 0.2 m beyond the front corner, and reaches 0.5 m beyond the back one.
  auto& right = grid.lines[1].stations;
  while (right.back().along_m > 1.2) right.pop_back();
  right.push_back(line_at(LineAxis::kZ, 1.0, {1.2}).stations[0]);
  const CornerView front = corner_view(grid, grid.cells[0], Side::kFront, {0.25, 0.4});
  EXPECT_NEAR(front.to_this_side_m, 0.6, 1e-15);
  EXPECT_NEAR(front.to_next_side_m, 0.75, 1e-15);
  EXPECT_NEAR(front.overhang_this_m, 0.5, 1e-12);
  EXPECT_NEAR(front.overhang_next_m, 0.2, 1e-12);
  const CornerView right_corner = corner_view(grid, grid.cells[0], Side::kRight, {0.25, 0.4});
  EXPECT_NEAR(right_corner.to_this_side_m, 0.75, 1e-15);
  EXPECT_NEAR(right_corner.to_next_side_m, 1.4, 1e-15);
  EXPECT_NEAR(right_corner.overhang_this_m, 0.5, 1e-12);
}

TEST(ViewPlan, ViewBetweenTwoStationsReadsThemAllAround) {
  const Grid grid = square_grid(1.0, 1.0);
  const RaySource between{.line = 2, .station = 0, .fraction = 0.25};
  const ViewPlan plan(grid, {7.0, 0.125, -3.0}, between);
  EXPECT_EQ(plan.height_m(), 0.125) << "the position's own, wherever it is";
  EXPECT_EQ(plan.viewpoint().x_m, 7.0);
  EXPECT_EQ(plan.viewpoint().z_m, -3.0);
  EXPECT_THAT(plan.lines(), testing::ElementsAre(2));
  for (int degree = -180; degree < 180; degree += 15) {
    const ColumnPlan column = plan.column(radians_from_degrees(degree));
    ASSERT_EQ(column.front_count, 2);
    EXPECT_EQ(column.behind_count, 0);
    for (const size_t i : {0u, 1u}) {
      EXPECT_EQ(column.front[i].line, 2);
      EXPECT_EQ(column.front[i].station, 0);
      EXPECT_EQ(column.front[i].fraction, static_cast<double>(i)) << "one of the stations alone";
      EXPECT_EQ(column.front[i].weight, i == 0 ? 0.75 : 0.25);
      EXPECT_EQ(column.front[i].d_p_m, 0.0);
    }
  }
}

TEST(ViewPlan, ViewAtAStationReadsThatOne) {
  const Grid grid = square_grid(1.0, 1.0);
  for (const double fraction : {0.0, 1.0}) {
    const ViewPlan plan(grid, {0.0, 0.0, 0.0},
                        RaySource{.line = 2, .station = 0, .fraction = fraction});
    const ColumnPlan column = plan.column(0.0);
    ASSERT_EQ(column.front_count, 1);
    EXPECT_EQ(column.front[0].fraction, fraction);
    EXPECT_EQ(column.front[0].weight, 1.0);
  }
}

TEST(LineCrossing, LiesOnTheRayAndOnAnObliqueLine) {
  Line line = line_at(LineAxis::kX, 0.5, {-1.0, 0.0, 1.0});
  const double oblique = radians_from_degrees(2.0);
  line.direction = {std::cos(oblique), std::sin(oblique)};
  const PlanPoint viewpoint{0.2, -0.3};
  for (const double theta_deg : {-70.0, -10.0, 0.0, 33.0, 80.0}) {
    const double theta = radians_from_degrees(theta_deg);
    const auto crossing = cross_line(line, viewpoint, theta);
    ASSERT_TRUE(crossing.has_value());
    const PlanPoint a = point_on(line, crossing->along_m);
    EXPECT_NEAR(a.x_m, viewpoint.x_m + crossing->d_p_m * std::sin(theta), 1e-14);
    EXPECT_NEAR(a.z_m, viewpoint.z_m + crossing->d_p_m * std::cos(theta), 1e-14);
  }
}

TEST(LineCrossing, ParallelRayBesideTheLineHasNone) {
  const Line line = line_at(LineAxis::kZ, 0.5, {-1.0, 1.0});
  EXPECT_FALSE(cross_line(line, {0.2, 0.0}, 0.0).has_value());
}

TEST(RaySource, InterpolatesBetweenIrregularStations) {
  const Line line = line_at(LineAxis::kX, 0.0, {-1.0, -0.9, 0.3, 0.35, 2.0});
  const struct {
    double along_m;
    int station;
    double fraction;
  } cases[] = {{-0.95, 0, 0.5}, {0.0, 1, 0.75}, {0.3, 2, 0.0}, {1.175, 3, 0.5}};
  for (const auto& c : cases) {
    const RaySource source = source_at(line, 7, {0.4, c.along_m});
    EXPECT_EQ(source.line, 7);
    EXPECT_EQ(source.d_p_m, 0.4);
    EXPECT_EQ(source.station, c.station) << c.along_m;
    EXPECT_NEAR(source.fraction, c.fraction, 1e-12) << c.along_m;
  }
}

TEST(RaySource, ReadsTheEndOfTheLineBeyondIt) {
  const Line line = line_at(LineAxis::kX, 0.0, {-1.0, 0.0, 1.0});
  EXPECT_EQ(source_at(line, 0, {1.0, -5.0}).station, 0);
  EXPECT_EQ(source_at(line, 0, {1.0, -5.0}).fraction, 0.0);
  for (const double at : {1.0, 5.0}) {
    EXPECT_EQ(source_at(line, 0, {1.0, at}).station, 1);
    EXPECT_EQ(source_at(line, 0, {1.0, at}).fraction, 1.0);
  }
}

// A single line is the paper's 3D360: no cell, but the views its captured part is seen in.
class SingleLine : public testing::Test {
 protected:
  SingleLine() { grid_.lines = {line_at(LineAxis::kX, 1.0, {-1.0, -0.5, 0.0, 0.5, 1.0})}; }
  Grid grid_;
};

TEST_F(SingleLine, ServesTheColumnsWhoseRaysCrossIt) {
  const ViewPlan plan(grid_, {0.0, 0.0}, kPhysical);  // sees it under -45..45 degrees
  for (int i = -180; i < 180; ++i) {
    const ColumnPlan column = plan.column(radians_from_degrees(i + 0.5));
    const bool seen = i >= -45 && i < 45;
    ASSERT_EQ(column.front_count, seen ? 1 : 0) << i;
    if (!seen) continue;
    EXPECT_NEAR(column.front[0].d_p_m, 1.0 / std::cos(radians_from_degrees(i + 0.5)), 1e-12);
    EXPECT_EQ(column.front[0].weight, 1.0);
  }
}

TEST_F(SingleLine, ServesEveryColumnFromAViewpointOnIt) {
  const ViewPlan plan(grid_, {0.25, 1.0}, kPhysical);
  for (int i = 0; i < 360; ++i) {
    const ColumnPlan column = plan.column(radians_from_degrees(i));
    ASSERT_EQ(column.front_count, 1);
    EXPECT_EQ(column.front[0].d_p_m, 0.0);
    EXPECT_NEAR(position_of(grid_, column.front[0]), 0.25, 1e-12);
  }
}

TEST_F(SingleLine, RefusesAViewpointThatSeesNothingOfIt) {
  EXPECT_THROW(ViewPlan(grid_, {3.0, 1.0}, kPhysical), Error);
}

TEST(OpenGrid, ReadsTheNearerOfTwoLines) {
  Grid grid;
  grid.lines = {line_at(LineAxis::kX, 2.0, {-1.0, 1.0}), line_at(LineAxis::kX, 1.0, {-1.0, 1.0})};
  const ColumnPlan column = ViewPlan(grid, {0.0, 0.0}, kPhysical).column(0.1);
  ASSERT_EQ(column.front_count, 1);
  EXPECT_EQ(column.front[0].line, 1);
}

}  // namespace
}  // namespace raywalk
