#include "core/geometry/grid.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>

#include "core/base/error.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A straight capture of `count` stations starting at (x, z), named <name>_000.jpg and so on.
struct Capture {
  std::string name;
  double x_m, z_m;
  double step_x_m, step_z_m;
  int count;
};

std::vector<StationPose> captured(const std::vector<Capture>& runs) {
  std::vector<StationPose> stations;
  for (const Capture& run : runs) {
    for (int i = 0; i < run.count; ++i) {
      stations.push_back({fmt::format("{}_{:03}.jpg", run.name, i),
                          {run.x_m + i * run.step_x_m, 0.0, run.z_m + i * run.step_z_m},
                          fmt::format("poses.csv:{}", stations.size() + 2)});
    }
  }
  return stations;
}

// The four lines of a unit square, 25 % overhang, with a station of either line at each corner.
std::vector<StationPose> square() {
  return captured({{"front", -0.75, 0.5, 0.05, 0.0, 31},
                   {"back", -0.75, -0.5, 0.05, 0.0, 31},
                   {"left", -0.5, -0.75, 0.0, 0.05, 31},
                   {"right", 0.5, -0.75, 0.0, 0.05, 31}});
}

// Captures lines x = 0, 1, .. columns and z = 0, 1, .. rows, each through the whole grid.
std::vector<StationPose> grid_of_lines(int columns, int rows, double width_m, double depth_m) {
  std::vector<Capture> runs;
  for (int row = 0; row <= rows; ++row) {
    runs.push_back(
        {fmt::format("row{}", row), 0.0, row * depth_m, width_m / 10, 0.0, columns * 10 + 1});
  }
  for (int column = 0; column <= columns; ++column) {
    runs.push_back(
        {fmt::format("column{}", column), column * width_m, 0.0, 0.0, depth_m / 8, rows * 8 + 1});
  }
  return captured(runs);
}

std::string capture_of(const std::string& file) { return file.substr(0, file.find('_')); }

// Every line must consist of the stations of one capture, whole.
void expect_lines_are_captures(const Grid& grid, size_t stations) {
  size_t assigned = 0;
  for (const Line& line : grid.lines) {
    for (const Station& station : line.stations) {
      EXPECT_EQ(capture_of(station.file), capture_of(line.stations.front().file)) << line.id;
    }
    assigned += line.stations.size();
  }
  EXPECT_EQ(assigned, stations);
}

std::string error_of(const std::vector<StationPose>& stations, GridTolerance tolerance = {}) {
  try {
    find_grid(stations, tolerance);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(FindGrid, SquareHasFourLinesAndOneCell) {
  const Grid grid = find_grid(square(), {});
  ASSERT_EQ(grid.lines.size(), 4U);
  ASSERT_EQ(grid.cells.size(), 1U);
  const Cell& cell = grid.cells[0];
  const auto side = [&](Side s) {
    return grid.lines[static_cast<size_t>(cell.line[static_cast<size_t>(s)])];
  };
  EXPECT_EQ(capture_of(side(Side::kFront).stations[0].file), "front");
  EXPECT_EQ(capture_of(side(Side::kRight).stations[0].file), "right");
  EXPECT_EQ(capture_of(side(Side::kBack).stations[0].file), "back");
  EXPECT_EQ(capture_of(side(Side::kLeft).stations[0].file), "left");
  EXPECT_NEAR(cell.x_min_m, -0.5, 1e-12);
  EXPECT_NEAR(cell.x_max_m, 0.5, 1e-12);
  EXPECT_NEAR(cell.z_min_m, -0.5, 1e-12);
  EXPECT_NEAR(cell.z_max_m, 0.5, 1e-12);
}

TEST(FindGrid, LinesAreNamedByAxisInOrderOfPlace) {
  const Grid grid = find_grid(square(), {});
  std::map<std::string, std::string> capture_of_id;
  for (const Line& line : grid.lines) capture_of_id[line.id] = capture_of(line.stations[0].file);
  const std::map<std::string, std::string> expected{
      {"x0", "back"}, {"x1", "front"}, {"z0", "left"}, {"z1", "right"}};
  EXPECT_EQ(capture_of_id, expected);
}

TEST(FindGrid, AlongIncreasesAndReproducesPositions) {
  for (const Line& line : find_grid(square(), {}).lines) {
    EXPECT_NEAR(line.first_m(), 0.0, 1e-12);
    for (size_t i = 0; i < line.stations.size(); ++i) {
      const Station& station = line.stations[i];
      if (i > 0) {
        EXPECT_GT(station.along_m, line.stations[i - 1].along_m);
      }
      EXPECT_NEAR(line.origin.x_m + station.along_m * line.direction.x_m, station.position_m.x(),
                  1e-12);
      EXPECT_NEAR(line.origin.z_m + station.along_m * line.direction.z_m, station.position_m.z(),
                  1e-12);
    }
  }
}

TEST(FindGrid, CornerStationsStayWithTheirCapture) {
  expect_lines_are_captures(find_grid(square(), {}), 124);
}

TEST(FindGrid, CornerStationsOfShortLinesStayWithTheirCaptureWhateverItsName) {
  for (const int count : {6, 7, 8, 12}) {
    // One station beyond each corner.
    const double step_m = 1.0 / (count - 3), first_m = -0.5 - step_m;
    std::vector<std::string> names{"a", "b", "c", "d"};
    do {
      const Grid grid = find_grid(captured({{names[0], first_m, 0.5, step_m, 0.0, count},
                                            {names[1], first_m, -0.5, step_m, 0.0, count},
                                            {names[2], -0.5, first_m, 0.0, step_m, count},
                                            {names[3], 0.5, first_m, 0.0, step_m, count}}),
                                  {});
      ASSERT_EQ(grid.lines.size(), 4U);
      expect_lines_are_captures(grid, static_cast<size_t>(4 * count));
    } while (std::next_permutation(names.begin(), names.end()));
  }
}

TEST(FindGrid, OrderOfTheListDoesNotMatterIfNamesAreOrdered) {
  std::vector<StationPose> stations = square();
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::shuffle(stations.begin(), stations.end(), std::mt19937(seed));
    const Grid grid = find_grid(stations, {});
    ASSERT_EQ(grid.lines.size(), 4U);
    EXPECT_EQ(grid.cells.size(), 1U);
    expect_lines_are_captures(grid, 124);
  }
}

TEST(FindGrid, NamesDoNotMatterWhenTheListIsInCaptureOrder) {
  std::vector<StationPose> stations = square();
  std::map<std::string, std::string> original;
  std::vector<int> numbers(stations.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  std::shuffle(numbers.begin(), numbers.end(), std::mt19937(7));
  for (size_t i = 0; i < stations.size(); ++i) {
    const std::string name = fmt::format("img{:05}.jpg", numbers[i]);
    original[name] = capture_of(stations[i].file);
    stations[i].file = name;
  }
  for (const Line& line : find_grid(stations, {}).lines) {
    for (const Station& station : line.stations) {
      EXPECT_EQ(original[station.file], original[line.stations[0].file]);
    }
  }
}

TEST(FindGrid, LinesMayBeObliqueAndStationsJitter) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> jitter_m(-0.0015, 0.0015);
  for (double degrees : {-2.0, 0.7, 2.0}) {
    std::vector<StationPose> stations = square();
    const double slope = std::tan(radians_from_degrees(degrees));
    for (StationPose& station : stations) {
      Eigen::Vector3d& p = station.position_m;
      const bool along_x = station.file.starts_with("front") || station.file.starts_with("back");
      (along_x ? p.z() : p.x()) += slope * (along_x ? p.x() : p.z());
      p += Eigen::Vector3d(jitter_m(random), jitter_m(random), jitter_m(random));
    }
    const Grid grid = find_grid(stations, {});
    ASSERT_EQ(grid.lines.size(), 4U) << degrees;
    EXPECT_EQ(grid.cells.size(), 1U) << degrees;
    expect_lines_are_captures(grid, 124);
    for (const Line& line : grid.lines) {
      const double found = line.axis == LineAxis::kX ? line.direction.z_m / line.direction.x_m
                                                     : line.direction.x_m / line.direction.z_m;
      EXPECT_NEAR(degrees_from_radians(std::atan(found)), degrees, 0.1);
    }
  }
}

TEST(FindGrid, GridsOfEverySizeCloseAllTheirCells) {
  for (int columns = 1; columns <= 4; ++columns) {
    for (int rows = 1; rows <= 3; ++rows) {
      const std::vector<StationPose> stations = grid_of_lines(columns, rows, 1.0, 0.7);
      const Grid grid = find_grid(stations, {});
      EXPECT_EQ(grid.lines.size(), static_cast<size_t>(columns + rows + 2));
      ASSERT_EQ(grid.cells.size(), static_cast<size_t>(columns * rows));
      expect_lines_are_captures(grid, stations.size());
      double area = 0.0;
      for (const Cell& cell : grid.cells) {
        area += (cell.x_max_m - cell.x_min_m) * (cell.z_max_m - cell.z_min_m);
      }
      EXPECT_NEAR(area, columns * rows * 0.7, 1e-9);
    }
  }
}

// Stations of parallel lines also align across the lines; these rows must not become lines.
TEST(FindGrid, ManyShortParallelLinesAreNotMistakenForRows) {
  std::vector<Capture> runs;
  for (int i = 0; i < 12; ++i) runs.push_back({fmt::format("z{}", i), i * 1.0, 0.0, 0.0, 0.1, 6});
  const Grid grid = find_grid(captured(runs), {});
  ASSERT_EQ(grid.lines.size(), 12U);
  for (const Line& line : grid.lines) EXPECT_EQ(line.axis, LineAxis::kZ);
  EXPECT_TRUE(grid.cells.empty());
}

TEST(FindGrid, SpacingMayBeIrregular) {
  std::vector<StationPose> stations;
  double x = 0.0;
  for (int i = 0; i < 40; ++i) {
    stations.push_back({fmt::format("a_{:03}.jpg", i), {x, 1.2, 3.0}, ""});
    x += 0.02 + 0.03 * ((i * 7) % 5) / 5.0;
  }
  const Grid grid = find_grid(stations, {});
  ASSERT_EQ(grid.lines.size(), 1U);
  EXPECT_EQ(grid.lines[0].stations.size(), 40U);
  EXPECT_NEAR(grid.lines[0].height_m, 1.2, 1e-12);
}

TEST(FindGrid, OneLineIsAGridWithoutCells) {
  const Grid grid = find_grid(captured({{"only", 0.0, 0.0, 0.1, 0.0, 5}}), {});
  EXPECT_EQ(grid.lines.size(), 1U);
  EXPECT_TRUE(grid.cells.empty());
}

TEST(FindGrid, MissingSideLeavesTheCellOpen) {
  std::vector<StationPose> stations = square();
  std::erase_if(stations, [](const StationPose& s) { return s.file.starts_with("right"); });
  EXPECT_TRUE(find_grid(stations, {}).cells.empty());
}

TEST(FindGrid, SideWithALongGapLeavesTheCellOpenButALostFrameDoesNot) {
  std::vector<StationPose> stations = square();
  std::erase_if(stations, [](const StationPose& s) { return s.file == "front_015.jpg"; });
  EXPECT_EQ(find_grid(stations, {}).cells.size(), 1U);
  std::erase_if(stations, [](const StationPose& s) {
    return s.file > "front_012.jpg" && s.file < "front_018.jpg";
  });
  EXPECT_TRUE(find_grid(stations, {}).cells.empty());
}

TEST(FindGrid, OneStationAtACrossingGoesToTheLineWithTheLargerGap) {
  // The left line ends at its corner with the front line; without it, it would be short of the
  // corner.
  std::vector<StationPose> stations =
      captured({{"front", -0.75, 0.5, 0.05, 0.0, 31}, {"left", -0.5, -0.75, 0.0, 0.05, 26}});
  std::erase_if(stations, [](const StationPose& s) { return s.file == "front_005.jpg"; });
  const Grid grid = find_grid(stations, {});
  ASSERT_EQ(grid.lines.size(), 2U);
  EXPECT_EQ(grid.lines[1].stations.back().file, "left_025.jpg");
  expect_lines_are_captures(grid, stations.size());
}

TEST(FindGrid, MovingTheWholeGridMovesTheResult) {
  std::vector<StationPose> stations = square();
  const Eigen::Vector3d shift(1234.5, 10.0, -987.0);
  for (StationPose& station : stations) station.position_m += shift;
  const Grid grid = find_grid(stations, {});
  ASSERT_EQ(grid.cells.size(), 1U);
  EXPECT_NEAR(grid.cells[0].x_min_m, 1234.0, 1e-9);
  EXPECT_NEAR(grid.cells[0].z_max_m, -986.5, 1e-9);
}

TEST(FindGrid, DuplicateAwayFromACrossingNamesBothFilesAndLines) {
  std::vector<StationPose> stations = square();
  stations.push_back({"again.jpg", stations[3].position_m, "poses.csv:126"});
  EXPECT_THAT(error_of(stations), AllOf(HasSubstr("front_003.jpg (poses.csv:5)"),
                                        HasSubstr("again.jpg (poses.csv:126)")));
}

// The repeated station lines up with those of the other rows.
TEST(FindGrid, DuplicateAmongParallelLinesIsNamedAsOne) {
  std::vector<StationPose> stations = captured(
      {{"a", 0.0, 0.0, 0.1, 0.0, 8}, {"b", 0.0, 0.5, 0.1, 0.0, 8}, {"c", 0.0, 1.0, 0.1, 0.0, 8}});
  stations.push_back({"again.jpg", stations[11].position_m, "poses.csv:26"});
  EXPECT_THAT(error_of(stations),
              AllOf(HasSubstr("b_003.jpg (poses.csv:13)"), HasSubstr("again.jpg (poses.csv:26)"),
                    HasSubstr("have the same position")));
}

TEST(FindGrid, TwoStationsAtOnePlaceAreNamedAsThat) {
  EXPECT_THAT(error_of(captured({{"a", 0.2, 0.3, 0.0, 0.0, 2}})),
              AllOf(HasSubstr("a_000.jpg (poses.csv:2) and a_001.jpg (poses.csv:3)"),
                    HasSubstr("have the same position (x = 0.2, z = 0.3)")));
}

// Every station in the middle of a long line has the same rank among its neighbours, so that a
// search which compares all with all would take minutes.
TEST(FindGrid, ManyStationsAreFoundSoon) {
  const std::vector<StationPose> stations = captured({{"a", 0.0, 0.0, 0.01, 0.0, 20000},
                                                      {"b", 0.0, 199.99, 0.01, 0.0, 20000},
                                                      {"c", 0.0, 0.0, 0.0, 0.01, 20000},
                                                      {"d", 199.99, 0.0, 0.0, 0.01, 20000}});
  const Grid grid = find_grid(stations, {});
  EXPECT_EQ(grid.lines.size(), 4U);
  EXPECT_EQ(grid.cells.size(), 1U);
}

TEST(FindGrid, ThirdStationAtACrossingIsAnError) {
  std::vector<StationPose> stations = square();
  const auto corner = std::find_if(stations.begin(), stations.end(),
                                   [](const StationPose& s) { return s.file == "front_005.jpg"; });
  stations.push_back({"third.jpg", corner->position_m, "poses.csv:126"});
  EXPECT_THAT(error_of(stations), AllOf(HasSubstr("front_005.jpg"), HasSubstr("third.jpg")));
}

TEST(FindGrid, StationOffEveryLineIsNamed) {
  for (bool first : {false, true}) {
    std::vector<StationPose> stations = square();
    const StationPose stray{"stray.jpg", {0.3, 0.0, 0.53}, "poses.csv:9"};
    stations.insert(first ? stations.begin() : stations.end(), stray);
    EXPECT_THAT(error_of(stations), HasSubstr("stray.jpg (poses.csv:9)"));
  }
}

TEST(FindGrid, ToleranceDecidesHowFarOffAStationMayBe) {
  std::vector<StationPose> stations = captured({{"a", 0.0, 0.0, 0.1, 0.0, 20}});
  stations[7].position_m.z() = 0.015;
  EXPECT_THAT(error_of(stations), HasSubstr("a_007.jpg"));
  EXPECT_EQ(error_of(stations, {0.02}), "no error");
}

TEST(FindGrid, StationAtAnotherHeightIsNamed) {
  std::vector<StationPose> stations = square();
  stations[12].position_m.y() = 0.4;
  EXPECT_THAT(error_of(stations),
              AllOf(HasSubstr("front_012.jpg (poses.csv:14) is 38"), HasSubstr("mm above")));
}

TEST(FindGrid, LineWithOneStationIsAnError) {
  EXPECT_THAT(error_of(captured({{"lonely", 0.0, 0.0, 0.1, 0.0, 1}})),
              AllOf(HasSubstr("lonely_000.jpg"), HasSubstr("at least two")));
  std::vector<StationPose> stations = captured({{"a", 0.0, 0.0, 0.1, 0.0, 9}});
  stations.push_back({"b_000.jpg", {0.33, 0.0, 0.5}, ""});
  EXPECT_THAT(error_of(stations), HasSubstr("b_000.jpg"));
}

TEST(FindGrid, CoordinatesThatAreNotFiniteAreAnError) {
  for (double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    std::vector<StationPose> stations = square();
    stations[4].position_m.y() = bad;
    EXPECT_THAT(error_of(stations), AllOf(HasSubstr("front_004.jpg"), HasSubstr("not finite")));
  }
}

TEST(FindGrid, NoStationsIsAnError) { EXPECT_THAT(error_of({}), HasSubstr("no stations")); }

TEST(FindCell, BordersBelongToACellAndOutsideToNone) {
  const Grid grid = find_grid(grid_of_lines(2, 1, 1.0, 1.0), {});
  const auto x_min = [&](PlanPoint point) {
    const std::optional<int> cell = find_cell(grid, point);
    return cell ? grid.cells[static_cast<size_t>(*cell)].x_min_m : std::nan("");
  };
  EXPECT_NEAR(x_min({0.5, 0.5}), 0.0, 1e-12);
  EXPECT_NEAR(x_min({1.5, 0.5}), 1.0, 1e-12);
  EXPECT_TRUE(find_cell(grid, {1.0, 0.5}).has_value());
  EXPECT_FALSE(find_cell(grid, {2.1, 0.5}).has_value());
  EXPECT_FALSE(find_cell(grid, {0.5, -0.1}).has_value());
  EXPECT_FALSE(find_cell(grid, {std::nan(""), 0.5}).has_value());
}

TEST(CrossingOf, LiesOnBothLines) {
  const Grid grid = find_grid(square(), {});
  const PlanPoint corner = crossing_of(grid.lines[1], grid.lines[2]);  // front, left
  EXPECT_NEAR(corner.x_m, -0.5, 1e-12);
  EXPECT_NEAR(corner.z_m, 0.5, 1e-12);
  EXPECT_NEAR(along_line(grid.lines[1], corner), 0.25, 1e-12);
}

}  // namespace
}  // namespace raywalk
