// Large grids, far from the origin, with spacings that no binary number holds: every cell is found
// whichever line has the stations at crossings, and no cell where stations are missing.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "core/geometry/line_gaps.h"
#include "core/geometry/position_tolerance.h"

namespace raywalk {
namespace {

// Which stations there are where lines cross.
enum class Crossings { kOfX, kOfZ, kOfBoth, kOfNone };

struct GridCase {
  int columns, rows;    // cells
  int steps;            // stations per cell side
  double spacing_m;     // between stations
  double x_m, z_m;      // of the corner
  Crossings crossings;  // of which lines their stations are
  int decimals = 9;     // of the list
};

std::string text_of(const GridCase& grid) {
  return fmt::format("{} x {} cells of {} steps of {} m at {}, {}, crossings {}, {} decimals",
                     grid.columns, grid.rows, grid.steps, grid.spacing_m, grid.x_m, grid.z_m,
                     static_cast<int>(grid.crossings), grid.decimals);
}

// A coordinate as a list of so many decimals has it.
double listed(double metres, int decimals) {
  return std::stod(fmt::format("{:.{}f}", metres, decimals));
}

// A station of line `line` along an axis, `step` steps from its beginning.
struct PlannedStation {
  LineAxis axis;
  int line, step;
};

std::vector<StationPose> stations_of(
    const GridCase& grid, const std::function<bool(const PlannedStation&)>& is_missing =
                              [](const auto&) { return false; }) {
  std::vector<StationPose> stations;
  const auto add_lines = [&](LineAxis axis, int lines, int cells, bool has_crossings) {
    for (int line = 0; line < lines; ++line) {
      for (int step = 0; step <= cells * grid.steps; ++step) {
        if ((!has_crossings && step % grid.steps == 0) || is_missing({axis, line, step})) continue;
        const double along_m = step * grid.spacing_m;
        const double across_m = line * grid.steps * grid.spacing_m;
        const bool is_x = axis == LineAxis::kX;
        stations.push_back({fmt::format("{}{:02}_{:04}", name_of(axis), line, step),
                            {listed(grid.x_m + (is_x ? along_m : across_m), grid.decimals), 0.0,
                             listed(grid.z_m + (is_x ? across_m : along_m), grid.decimals)},
                            ""});
      }
    }
  };
  const Crossings at = grid.crossings;
  add_lines(LineAxis::kX, grid.rows + 1, grid.columns,
            at == Crossings::kOfX || at == Crossings::kOfBoth);
  add_lines(LineAxis::kZ, grid.columns + 1, grid.rows,
            at == Crossings::kOfZ || at == Crossings::kOfBoth);
  return stations;
}

constexpr Crossings kAllCrossings[] = {Crossings::kOfX, Crossings::kOfZ, Crossings::kOfBoth,
                                       Crossings::kOfNone};

// Small grids of all kinds, at the origin and far from it.
std::vector<GridCase> small_grids() {
  std::vector<GridCase> grids;
  constexpr double kPlaces[] = {0.0, -100.0, 12345.678, -99999.9};
  constexpr double kSpacings[] = {0.02, 0.1 / 3.0, 0.7 / 9.0, 1.1};
  int turn = 0;
  for (const Crossings crossings : kAllCrossings) {
    for (const auto& [columns, rows] : {std::pair(1, 1), {2, 1}, {3, 4}, {9, 2}}) {
      for (const double x_m : kPlaces) {
        const double z_m = kPlaces[++turn % std::size(kPlaces)];
        const double spacing_m = kSpacings[turn % 5 % std::size(kSpacings)];
        grids.push_back({columns, rows, 6 + turn % 3, spacing_m, x_m, z_m, crossings});
      }
    }
  }
  return grids;
}

TEST(GridSize, EveryCellIsFoundNearAndFar) {
  for (const GridCase& grid : small_grids()) {
    const Grid found = find_grid(stations_of(grid), {});
    ASSERT_EQ(found.lines.size(), static_cast<size_t>(grid.columns + grid.rows + 2))
        << text_of(grid);
    EXPECT_EQ(found.cells.size(), static_cast<size_t>(grid.columns * grid.rows)) << text_of(grid);
    EXPECT_TRUE(line_notes(found).empty()) << text_of(grid);
  }
}

TEST(GridSize, EveryCellIsFoundInAListOfFewDecimals) {
  for (const Crossings crossings : kAllCrossings) {
    const GridCase grid{4, 3, 9, 0.1 / 3.0, -812.3456, 77.7, crossings, 3};
    EXPECT_EQ(find_grid(stations_of(grid), {}).cells.size(), 12U) << text_of(grid);
  }
}

TEST(GridSize, All336CellsOfALargeHallAreFound) {
  EXPECT_EQ(find_grid(stations_of({56, 6, 50, 0.02, 0.0, 0.0, Crossings::kOfX}), {}).cells.size(),
            336U);
  for (const Crossings crossings : kAllCrossings) {
    const GridCase grid{56, 6, 10, 0.1, 0.0, -3210.9, crossings};
    EXPECT_EQ(find_grid(stations_of(grid), {}).cells.size(), 336U) << text_of(grid);
  }
}

// Four lost frames are a section, three are not.
TEST(GridSize, AMissingSectionOpensItsCellWhereverTheGridIs) {
  for (const GridCase& grid : small_grids()) {
    // Short lines do not tell their spacing; without stations at crossings more are missing.
    if (grid.rows < 2 || grid.crossings == Crossings::kOfNone) continue;
    const int cells = grid.columns * grid.rows, middle = grid.steps / 2;
    for (const int lost : {3, 4}) {
      const auto in_section = [&](const PlannedStation& station) {
        return station.axis == LineAxis::kZ && station.line == grid.columns &&
               station.step >= middle - 2 && station.step < middle - 2 + lost;
      };
      const size_t expected = static_cast<size_t>(lost == 3 ? cells : cells - 1);
      EXPECT_EQ(find_grid(stations_of(grid, in_section), {}).cells.size(), expected)
          << text_of(grid) << ", " << lost << " lost";
    }
  }
}

// A line may end one spacing before a corner, not two.
TEST(GridSize, ALineThatEndsTwoSpacingsBeforeItsCornerClosesNoCell) {
  for (const GridCase& grid : small_grids()) {
    if (grid.crossings != Crossings::kOfNone) continue;
    const auto is_last = [&](const PlannedStation& station) {
      return station.axis == LineAxis::kX && station.line == grid.rows &&
             station.step >= grid.columns * grid.steps - 1;
    };
    EXPECT_EQ(find_grid(stations_of(grid, is_last), {}).cells.size(),
              static_cast<size_t>(grid.columns * grid.rows - 1))
        << text_of(grid);
  }
}

// A viewpoint on the border of the whole grid, typed as planned, is inside; one a tenth of a
// micrometre outside is not.
TEST(GridSize, ViewpointsOnTheBorderAreInside) {
  for (const GridCase& grid : small_grids()) {
    const Grid found = find_grid(stations_of(grid), {});
    const double width_m = grid.columns * grid.steps * grid.spacing_m;
    const double x_m = listed(grid.x_m + width_m, 9), z_m = listed(grid.z_m, 9);
    EXPECT_TRUE(find_cell(found, {x_m, z_m}).has_value()) << text_of(grid);
    EXPECT_FALSE(find_cell(found, {x_m + 1e-7, z_m}).has_value()) << text_of(grid);
  }
}

TEST(Rounding, GrowsWithTheCoordinatesAndStaysBelowWhatTellsStationsApart) {
  EXPECT_GT(rounding_m(56.0), std::abs((56.0 - 55.98) - 0.02));
  EXPECT_DOUBLE_EQ(rounding_m(1e5), 1e3 * rounding_m(1e2));
  EXPECT_LT(rounding_m(1e6), 1e-7);
}

}  // namespace
}  // namespace raywalk
