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

TEST(ViewHeight, LevelAndSloping) {
  const Line level = line_with_heights([](double) { return 1.5; });
  const Line sloping = line_with_heights([](double x_m) { return 0.2 + 0.1 * x_m; });
  for (const double x_m : {0.04, 0.3, 1.0, 3.33, 5.9}) {
    EXPECT_NEAR(height_along(level, x_m), 1.5, 1e-12);
    EXPECT_NEAR(height_along(sloping, x_m), 0.2 + 0.1 * x_m, 1e-12);
  }
  EXPECT_NEAR(height_along(sloping, -7.0), 0.2 + 0.1 * sloping.first_m(), 1e-12);
  EXPECT_NEAR(height_along(sloping, 70.0), 0.2 + 0.1 * sloping.last_m(), 1e-12);
}

TEST(ViewHeight, FollowsAHill) {
  const auto hill_m = [](double x_m) { return 0.3 * std::sin(x_m); };
  const Line line = line_with_heights(hill_m);
  for (double x_m = 0.05; x_m < 6.0; x_m += 0.07) {
    EXPECT_NEAR(height_along(line, x_m), hill_m(x_m), 0.012) << x_m;
  }
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
  for (std::size_t i = 4; i < 7; ++i) line.stations[i].position_m.y() = 0.9;
  EXPECT_NEAR(height_along(line, 0.1), 0.0, 1e-12);
  EXPECT_NEAR(height_along(line, 9.1), 0.9, 1e-12);
  for (double x_m = 0.5; x_m < 9.0; x_m += 0.1) {
    EXPECT_TRUE(std::isfinite(height_along(line, x_m))) << x_m;
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
