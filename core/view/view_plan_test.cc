#include "core/view/view_plan.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/files/test_support.h"
#include "core/geometry/sphere.h"
#include "core/view/connection.h"
#include "core/view/test_grid.h"
#include "core/view/view_height.h"

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

// The intersection of the front line: A = (x + (N/2 - z) tan theta, N/2), d_p = (N/2 - z) / cos
// theta.
TEST_P(ViewPlanScale, IntersectionHasTheClosedFormOnEverySide) {
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
    const auto intersection = cross_line(line, viewpoint, theta + side_normal_rad(Side(side)));
    ASSERT_TRUE(intersection.has_value());
    const PlanPoint p = seen_from_side(viewpoint, side);
    const PlanPoint a = seen_from_side(point_on(line, intersection->along_m), side);
    EXPECT_NEAR(intersection->d_p_m, (0.5 * n - p.z_m) / std::cos(theta), 1e-13 * n);
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

TEST(LineIntersection, LiesOnTheRayAndOnAnObliqueLineUnlessParallel) {
  EXPECT_FALSE(cross_line(line_at(LineAxis::kZ, 0.5, {-1.0, 1.0}), {0.2, 0.0}, 0.0));
  Line line = line_at(LineAxis::kX, 0.5, {-1.0, 0.0, 1.0});
  line.direction = {std::cos(0.03), std::sin(0.03)};
  for (const double theta : {-1.2, -0.2, 0.0, 0.6, 1.4}) {
    const auto intersection = cross_line(line, {0.2, -0.3}, theta);
    ASSERT_TRUE(intersection.has_value());
    const PlanPoint a = point_on(line, intersection->along_m);
    EXPECT_NEAR(a.x_m, 0.2 + intersection->d_p_m * std::sin(theta), 1e-14);
    EXPECT_NEAR(a.z_m, -0.3 + intersection->d_p_m * std::cos(theta), 1e-14);
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

constexpr double kPlentyM = 1e9;  // an overhang that never runs out

CornerView corner_at(double a, double b, double overhang = kPlentyM) {
  return {a, b, overhang, overhang};
}
double corner_angle(const CornerView& c) { return std::atan2(c.to_next_side_m, c.to_this_side_m); }

// Corners with all four lengths log-uniform over 1e-9..1e6, now and then exactly 0.
class RandomCorners {
 public:
  CornerView next() { return {length(), length(), length(), length()}; }
  double angle_deg(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

 private:
  double length() {
    if (std::uniform_int_distribution<int>(0, 15)(random_) == 0) return 0.0;
    return std::pow(10.0, std::uniform_real_distribution<double>(-9.0, 6.0)(random_));
  }
  std::mt19937_64 random_{7};
};

TEST(Connection, CutIsTheCornerAngleClampedToTheAllowedIncidence) {
  // k = 70 allows 20..70 degrees.
  for (const auto& [corner_deg, cut_deg] : {std::pair{15.0, 20.0}, {45.0, 45.0}, {75.0, 70.0}}) {
    const double c = radians_from_degrees(corner_deg);
    const CornerView corner = corner_at(std::sin(c), std::cos(c));
    EXPECT_NEAR(degrees_from_radians(hybrid_cut(corner, radians_from_degrees(70.0))), cut_deg,
                1e-12);
  }
}

TEST(Connection, LfuCutsAtTheDiagonalAndRaySpace360AtTheCornerWithoutOverhang) {
  RandomCorners corners;
  for (int i = 0; i < 2000; ++i) {
    CornerView corner = corners.next();
    const CornerConnection physical = connect_corner(corner, rule_of(90.0));
    EXPECT_EQ(physical.cut_rad, corner_angle(corner));
    EXPECT_FALSE(physical.limited);
    corner.overhang_this_m = corner.overhang_next_m = kPlentyM;
    if (corner.to_this_side_m + corner.to_next_side_m > 1e3) continue;
    EXPECT_NEAR(degrees_from_radians(connect_corner(corner, rule_of(45.0)).cut_rad), 45.0, 1e-4);
  }
}

TEST(Connection, SharedAnglesEndWhereEitherLineEnds) {
  // 1 m to the next side, 0.5 m to this one. This line reaches 0.25 m beyond the corner, seen at
  // atan(1.25 / 0.5); the next one 0.5 m, seen at atan(1 / (0.5 + 0.5)) = 45 degrees.
  const SharedAngles shared = shared_angles({1.0, 0.5, 0.25, 0.5});
  EXPECT_NEAR(degrees_from_radians(shared.begin_rad), 45.0, 1e-12);
  EXPECT_NEAR(shared.end_rad, std::atan(2.5), 1e-15);
}

TEST(Connection, CutMovesContinuouslyTowardsPhysicalAsTheOverhangRunsOut) {
  // Both sides of the diagonal: the next line's overhang limits c > k, this line's c < 90 - k.
  for (const auto& [a, b] : {std::pair{1.0, 0.2}, {0.2, 1.0}}) {
    double previous = hybrid_cut(corner_at(a, b), radians_from_degrees(50.0));
    bool was_limited = false;
    for (double overhang = 2.0; overhang >= 0.0; overhang -= 0.001) {
      const CornerConnection connection =
          connect_corner(corner_at(a, b, std::max(0.0, overhang)), rule_of(50.0));
      const double c = corner_angle(corner_at(a, b));
      EXPECT_LE(std::fabs(connection.cut_rad - c), std::fabs(previous - c) + 1e-15);
      // |d cut / d overhang| <= 1 / hypot(a, b + o) < 1.
      EXPECT_LT(std::fabs(connection.cut_rad - previous), 0.001 + 1e-12) << overhang;
      EXPECT_TRUE(connection.limited || !was_limited) << "limits come and stay";
      was_limited = connection.limited;
      previous = connection.cut_rad;
    }
    EXPECT_TRUE(was_limited);
  }
}

TEST(ConnectionProperty, CutAndBlendStayWithinBothLines) {
  RandomCorners corners;
  for (int i = 0; i < 20000; ++i) {
    const CornerView corner = corners.next();
    const ConnectionRule rule =
        rule_of(corners.angle_deg(45.0, 90.0), corners.angle_deg(0.0, 45.0));
    const SharedAngles shared = shared_angles(corner);
    const CornerConnection connection = connect_corner(corner, rule);
    ASSERT_GE(shared.begin_rad, 0.0);
    ASSERT_LE(shared.begin_rad, shared.end_rad);
    ASSERT_LE(shared.end_rad, kHalfPi);
    ASSERT_GE(connection.blend_begin_rad, shared.begin_rad);
    ASSERT_LE(connection.blend_begin_rad, connection.cut_rad);
    ASSERT_LE(connection.cut_rad, connection.blend_end_rad);
    ASSERT_LE(connection.blend_end_rad, shared.end_rad);
    const double wanted = hybrid_cut(corner, rule.k_rad);
    const bool readable = wanted >= shared.begin_rad && wanted <= shared.end_rad;
    ASSERT_EQ(connection.limited, !readable);
    if (readable) {
      ASSERT_EQ(connection.cut_rad, wanted);
    }
  }
}

// A line along x with heights y(x), its stations unevenly spaced.
Line line_with_heights(const std::function<double(double)>& height_m) {
  std::vector<double> positions_m;
  for (int i = 0; i <= 60; ++i) positions_m.push_back(0.1 * i + (i % 3 == 0 ? 0.04 : 0.0));
  Line line = line_at(LineAxis::kX, 0.0, positions_m);
  for (Station& station : line.stations) {
    station.position_m.y() = height_m(station.along_m);
    line.height_m += station.position_m.y() / static_cast<double>(line.stations.size());
  }
  return line;
}

TEST(ViewHeight, FollowsLevelSlopingAndHillyLines) {
  const Line sloping = line_with_heights([](double x_m) { return 0.2 + 0.1 * x_m; });
  const auto hill_m = [](double x_m) { return 0.3 * std::sin(x_m); };
  const Line hilly = line_with_heights(hill_m);
  for (double x_m = 0.05; x_m < 6.0; x_m += 0.07) {
    EXPECT_NEAR(height_along(sloping, x_m), 0.2 + 0.1 * x_m, 1e-12);
    EXPECT_NEAR(height_along(hilly, x_m), hill_m(x_m), 0.012) << x_m;
  }
  EXPECT_NEAR(height_along(sloping, -7.0), 0.2 + 0.1 * sloping.first_m(), 1e-12);
  EXPECT_NEAR(height_along(sloping, 70.0), 0.2 + 0.1 * sloping.last_m(), 1e-12);
  const Line with_gap = line_at(LineAxis::kX, 0.0, {0.0, 0.1, 0.2, 0.3, 9.0, 9.1, 9.2});
  for (double x_m = 0.0; x_m < 9.2; x_m += 0.1)
    EXPECT_NEAR(height_along(with_gap, x_m), 0.0, 1e-12);
}

TEST(ViewHeight, AveragesWhatSingleStationsAreOffAndIsContinuous) {
  const Line line =
      line_with_heights([](double x_m) { return std::lround(x_m * 10.0) % 2 == 0 ? 0.02 : -0.02; });
  double before = height_along(line, 0.5);
  for (double x_m = 0.5; x_m < 5.5; x_m += 0.001) {
    const double here = height_along(line, x_m);
    EXPECT_LT(std::abs(here), 0.007) << x_m;
    EXPECT_LT(std::abs(here - before), 5e-4) << x_m;
    before = here;
  }
}

TEST(ViewHeight, OfACellOnASlopeIsThatOfThePlane) {
  const auto plane_m = [](double x_m, double z_m) { return 1.0 + 0.05 * x_m - 0.03 * z_m; };
  Grid grid = square_grid(1.0, 0.25);
  for (Line& line : grid.lines) {
    for (Station& station : line.stations) {
      station.position_m.y() = plane_m(station.position_m.x(), station.position_m.z());
    }
  }
  for (const PlanPoint at : {PlanPoint{0.0, 0.0}, {0.5, 0.2}, {-0.31, 0.44}, {0.5, -0.5}}) {
    EXPECT_NEAR(height_in_cell(grid, grid.cells[0], at), plane_m(at.x_m, at.z_m), 1e-12);
  }
}

}  // namespace
}  // namespace raywalk
