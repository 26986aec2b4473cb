#include "core/view/view_height.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/view/test_grid.h"

namespace raywalk {
namespace {

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

TEST(ViewHeight, IsDefinedInALongGap) {
  Line line = line_at(LineAxis::kX, 0.0, {0.0, 0.1, 0.2, 0.3, 9.0, 9.1, 9.2});
  for (double x_m = 0.0; x_m < 9.2; x_m += 0.1) EXPECT_NEAR(height_along(line, x_m), 0.0, 1e-12);
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
