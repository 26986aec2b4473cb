// Grids that are found, of any size at any place, and what is said of those that are not.
#include "core/geometry/grid.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <utility>

#include "core/files/test_support.h"
#include "core/geometry/line_gaps.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

double uniform(std::mt19937* random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(*random);
}

// Which stations there are where lines cross.
enum class Intersections { kOfX, kOfZ, kOfBoth, kOfNone };

struct GridCase {
  int columns = 1, rows = 1;  // cells
  int steps = 10;             // stations per cell side
  double spacing_m = 0.1;     // between stations
  PlanPoint corner{};
  Intersections intersections = Intersections::kOfBoth;
  double off = 0.0;         // most distance of a station from its place, in spacings
  double turned_deg = 0.0;  // the whole grid
  int beyond = 0;           // stations of each line beyond its last corner

  int lines() const { return columns + rows + 2; }
  int cells() const { return columns * rows; }
};

// Stations named after their line, such as x02_0017.
std::vector<StationPose> stations_of(const GridCase& grid, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::vector<StationPose> stations;
  const double turn = radians_from_degrees(grid.turned_deg);
  const auto add_lines = [&](char axis, int lines, int cells, bool has_intersections) {
    for (int line = 0; line < lines; ++line) {
      for (int step = -grid.beyond; step <= cells * grid.steps + grid.beyond; ++step) {
        const bool inside = step >= 0 && step <= cells * grid.steps;
        if (inside && !has_intersections && step % grid.steps == 0) continue;
        const auto off = [&] { return uniform(&random, -grid.off, grid.off); };
        const double along_m = (step + off()) * grid.spacing_m;
        const double across_m = (line * grid.steps + off()) * grid.spacing_m;
        const double x_m = axis == 'x' ? along_m : across_m;
        const double z_m = axis == 'x' ? across_m : along_m;
        stations.push_back(
            {fmt::format("{}{:02}_{:04}", axis, line, step + grid.beyond),
             {grid.corner.x_m + std::cos(turn) * x_m - std::sin(turn) * z_m, off() * grid.spacing_m,
              grid.corner.z_m + std::sin(turn) * x_m + std::cos(turn) * z_m},
             fmt::format("poses.csv:{}", stations.size() + 2)});
      }
    }
  };
  const Intersections at = grid.intersections;
  add_lines('x', grid.rows + 1, grid.columns,
            at == Intersections::kOfX || at == Intersections::kOfBoth);
  add_lines('z', grid.columns + 1, grid.rows,
            at == Intersections::kOfZ || at == Intersections::kOfBoth);
  return stations;
}

// Stations from (x, z) on, 0.1 m apart.
void add_line(const std::string& name, LineAxis axis, double x, double z, int count,
              std::vector<StationPose>* stations) {
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d step =
        0.1 * i * Eigen::Vector3d(axis == LineAxis::kX, 0, axis == LineAxis::kZ);
    stations->push_back({fmt::format("{}{:02}", name, i), Eigen::Vector3d(x, 0.0, z) + step});
  }
}

std::string line_of(const std::string& file) { return file.substr(0, 3); }

// Every line has all stations of one planned line, and no others.
void expect_planned_lines(const Grid& grid, const std::vector<StationPose>& stations) {
  std::map<std::string, std::size_t> counts;
  for (const StationPose& station : stations) ++counts[line_of(station.file)];
  for (const Line& line : grid.lines) {
    EXPECT_EQ(line.stations.size(), counts[line_of(line.stations[0].file)]) << line.id;
    for (const Station& station : line.stations) {
      EXPECT_EQ(line_of(station.file), line_of(line.stations[0].file)) << line.id;
    }
  }
}

std::string error_of(const std::vector<StationPose>& stations, GridTolerance tolerance = {}) {
  return raywalk::error_of([&] { find_grid(stations, tolerance); });
}

StationPose* station_of(const std::string& file, std::vector<StationPose>* stations) {
  return &*std::ranges::find(*stations, file, &StationPose::file);
}

// From 1 mm to 1 m between stations, up to 1000 km from the origin, in any order.
TEST(FindGrid, EveryCellIsFoundWhereverItIs) {
  std::mt19937 random(5);
  const auto scaled = [&](double low, double high) {
    return std::exp(uniform(&random, std::log(low), std::log(high)));
  };
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    const GridCase grid{.columns = 1 + static_cast<int>(random() % 20),
                        .rows = 1 + static_cast<int>(random() % 20),
                        .steps = 4 + static_cast<int>(random() % 10),
                        .spacing_m = scaled(1e-3, 1.0),
                        .corner = {scaled(1.0, 1e6), -scaled(1.0, 1e6)},
                        .intersections = static_cast<Intersections>(random() % 4),
                        .off = i % 2 == 0 ? 0.0 : uniform(&random, 0.0, 0.05),
                        .turned_deg = i % 3 == 0 ? uniform(&random, -2.0, 2.0) : 0.0,
                        .beyond = static_cast<int>(random() % 3)};
    std::vector<StationPose> stations = stations_of(grid, random());
    std::ranges::shuffle(stations, random);
    const Grid found = find_grid(stations, {});
    EXPECT_EQ(found.lines.size(), static_cast<std::size_t>(grid.lines()));
    EXPECT_EQ(found.cells.size(), static_cast<std::size_t>(grid.cells()));
    EXPECT_TRUE(line_notes(found).empty());
    if (grid.off == 0.0 && grid.intersections == Intersections::kOfBoth) {
      expect_planned_lines(found, stations);
    }
    for (StationPose& station : stations) station.line = line_of(station.file);
    const Grid named = find_grid(stations, {});
    expect_planned_lines(named, stations);
    EXPECT_EQ(named.cells.size(), static_cast<std::size_t>(grid.cells()));
  }
}

TEST(FindGrid, SidesOfACellAndIdsOfLinesAreByPlace) {
  const Grid grid = find_grid(stations_of({.beyond = 2}), {});
  ASSERT_EQ(grid.cells.size(), 1U);
  std::vector<std::string> sides;
  for (const int line : grid.cells[0].line) {
    const Line& side = grid.lines[static_cast<std::size_t>(line)];
    sides.push_back(side.id + " " + line_of(side.stations[0].file));
  }
  EXPECT_THAT(sides, ElementsAre("x1 x01", "z1 z01", "x0 x00", "z0 z00"));
  EXPECT_NEAR(grid.cells[0].x_min_m, 0.0, 1e-12);
  EXPECT_NEAR(grid.cells[0].z_max_m, 1.0, 1e-12);
  const PlanPoint corner = intersection_of(grid.lines[1], grid.lines[3]);
  EXPECT_NEAR(along_line(grid.lines[1], corner), 1.2, 1e-12);
  for (const Line& line : grid.lines) {
    for (const Station& station : line.stations) {
      EXPECT_NEAR(line.origin.x_m + station.along_m * line.direction.x_m, station.position_m.x(),
                  1e-12);
    }
  }
}

TEST(FindGrid, EveryLineMayBeTurnedByItself) {
  std::vector<StationPose> stations = stations_of({.columns = 2, .spacing_m = 0.05, .beyond = 3});
  const std::map<std::string, double> turned{
      {"x00", 0.03}, {"x01", -0.02}, {"z00", -0.03}, {"z01", 0.01}, {"z02", 0.0}};
  for (StationPose& station : stations) {
    Eigen::Vector3d& at = station.position_m;
    const double slope = turned.at(line_of(station.file));
    (station.file[0] == 'x' ? at.z() : at.x()) +=
        slope * (station.file[0] == 'x' ? at.x() : at.z());
  }
  const Grid grid = find_grid(stations, {});
  EXPECT_EQ(grid.lines.size(), 5U);
  EXPECT_EQ(grid.cells.size(), 2U);
  EXPECT_NEAR(grid.lines[0].direction.z_m / grid.lines[0].direction.x_m, 0.03, 1e-3);
}

TEST(FindGrid, LinesMayBeOfUnequalLengthAndOutOfEachOthersReach) {
  std::vector<StationPose> stations = stations_of({.columns = 3, .rows = 2});
  // One cell is left of the second row; a line beyond all crosses the first line's continuation.
  std::erase_if(stations, [](const StationPose& station) {
    const Eigen::Vector3d& at = station.position_m;
    return at.z() > 1.05 && at.x() > 1.05;
  });
  add_line("z09_", LineAxis::kZ, 9.0, -1.0, 21, &stations);
  const Grid grid = find_grid(stations, {});
  EXPECT_EQ(grid.lines.size(), 8U);
  EXPECT_EQ(grid.cells.size(), 4U);
  expect_planned_lines(grid, stations);
}

// Stations of parallel lines also align across the lines; these rows must not become lines.
TEST(FindGrid, ParallelLinesAreNotMistakenForRows) {
  std::vector<StationPose> stations = stations_of({.columns = 11, .steps = 6});
  std::erase_if(stations, [](const StationPose& station) { return station.file[0] == 'x'; });
  const Grid grid = find_grid(stations, {});
  EXPECT_EQ(grid.lines.size(), 12U);
  EXPECT_TRUE(grid.cells.empty());
  for (const Line& line : grid.lines) EXPECT_EQ(line.axis, LineAxis::kZ);
}

// The two stations of an intersection may be apart, and the tolerance larger than the spacing.
TEST(FindGrid, StationsOffTheirLineAreWithTheirOwn) {
  for (const double off : {0.1, 0.3, 0.6}) {
    for (unsigned seed = 0; seed < 10; ++seed) {
      const GridCase plan{.columns = 2, .off = off, .beyond = 2};
      const std::vector<StationPose> stations = stations_of(plan, seed);
      const Grid grid = find_grid(stations, {.off_line_m = 0.15 * off, .same_station_m = 1e-9});
      EXPECT_EQ(grid.lines.size(), 5U) << off << ' ' << seed;
      EXPECT_EQ(grid.cells.size(), 2U) << off << ' ' << seed;
      for (const Line& line : grid.lines) {
        EXPECT_NEAR(static_cast<double>(line.stations.size()), line.axis == LineAxis::kX ? 25 : 15,
                    2.0);
      }
    }
  }
}

TEST(FindGrid, TwoPassesOfALineAreOneLine) {
  for (const double ahead_m : {0.001, 0.01, 0.05, 0.09}) {
    for (const double beside_m : {0.0, 0.005, 0.02}) {
      std::vector<StationPose> stations = stations_of({.beyond = 2});
      for (StationPose second : stations_of({.beyond = 2})) {
        const bool is_x = second.file[0] == 'x';
        second.position_m +=
            Eigen::Vector3d(is_x ? ahead_m : beside_m, 0.0, is_x ? beside_m : ahead_m);
        second.file += "_second";
        stations.push_back(second);
      }
      GridTolerance tolerance{.same_station_m = 5e-5};
      if (beside_m > 0.01) tolerance.off_line_m = 0.02;
      const Grid grid = find_grid(stations, tolerance);
      EXPECT_EQ(grid.lines.size(), 4U) << ahead_m << ' ' << beside_m;
      EXPECT_EQ(grid.cells.size(), 1U) << ahead_m << ' ' << beside_m;
    }
  }
}

TEST(FindGrid, OneStationAtAIntersectionIsOfTheLineThatEndsThere) {
  std::vector<StationPose> stations =
      stations_of({.columns = 2, .intersections = Intersections::kOfX});
  const Grid grid = find_grid(stations, {});
  EXPECT_EQ(grid.lines[3].stations.front().file, "x00_0010");
  EXPECT_EQ(grid.lines[0].stations.front().file, "x00_0000");
}

// Four lost frames are a section, three are not; a line may end one spacing before a corner.
TEST(FindGrid, ACellIsOpenWhereASectionIsMissing) {
  for (const int lost : {3, 4}) {
    std::vector<StationPose> stations = stations_of({.columns = 2, .rows = 2});
    std::erase_if(stations, [&](const StationPose& station) {
      return station.file >= "z02_0003" && station.file < fmt::format("z02_{:04}", 3 + lost);
    });
    const Grid grid = find_grid(stations, {});
    EXPECT_EQ(grid.cells.size(), lost == 3 ? 4U : 3U);
    if (lost == 3) continue;
    EXPECT_THAT(line_notes(grid), ElementsAre(HasSubstr("line z2 has no station for 0.5 m between "
                                                        "z02_0002 and z02_0007")));
  }
  for (const int lost : {1, 2}) {
    std::vector<StationPose> stations = stations_of({.columns = 2, .rows = 2});
    std::erase_if(stations, [&](const StationPose& station) {
      return station.file.starts_with("x02") && station.file > fmt::format("x02_{:04}", 20 - lost);
    });
    std::erase_if(stations, [](const StationPose& each) { return each.file == "z02_0020"; });
    EXPECT_EQ(find_grid(stations, {}).cells.size(), lost == 1 ? 4U : 3U);
  }
}

TEST(FindGrid, NamedLinesNeedNoNeighbours) {
  // Closer to each other than to be told apart, and off their lines by four tenths of the spacing.
  std::vector<StationPose> stations;
  for (int i = 0; i < 20; ++i) {
    const double off_m = i % 2 == 0 ? 0.04 : -0.04;
    stations.push_back({fmt::format("a{}", i), {0.1 * i, 0.0, off_m}, "", "a"});
    stations.push_back({fmt::format("b{}", i), {0.1 * i, 0.0, 0.05 - off_m}, "", "b"});
  }
  const Grid grid = find_grid(stations, {});
  ASSERT_EQ(grid.lines.size(), 2U);
  for (const Line& line : grid.lines) EXPECT_EQ(line.stations.size(), 20U);
  stations[6].position_m.z() = 0.2;
  EXPECT_THAT(error_of(stations),
              AllOf(HasSubstr("a3 is 1"), HasSubstr("mm off the line a along x"),
                    HasSubstr("--line-tolerance-mm 1")));
  stations[6].line = "";
  EXPECT_THAT(error_of(stations), AllOf(HasSubstr("a3"), HasSubstr("every frame or of none")));
  stations[6].line = "c";
  EXPECT_THAT(error_of(stations), AllOf(HasSubstr("a3"), HasSubstr("only station of line c")));
  EXPECT_THAT(error_of({stations[6]}), AllOf(HasSubstr("a3"), HasSubstr("the only station;")));
}

TEST(FindGrid, StrayStationsAreNamedWithTheNearestLine) {
  std::mt19937 random(3);
  for (int i = 0; i < 40; ++i) {
    std::vector<StationPose> stations = stations_of({.columns = 3, .rows = 2, .beyond = 1});
    // In a cell, in line with no station.
    stations.push_back({"stray", {uniform(&random, 1.02, 1.98), 0.0, uniform(&random, 1.2, 1.8)}});
    Eigen::Vector3d& at = stations.back().position_m;
    at = (10.0 * at).array().floor() * 0.1 + 0.05;
    EXPECT_THAT(error_of(stations),
                AllOf(HasSubstr("stray at x"), HasSubstr("beside the line along"),
                      HasSubstr("tolerance of 10 mm")));
  }
  std::vector<StationPose> stations = stations_of({.beyond = 1});
  station_of("x01_0007", &stations)->position_m.z() += 0.06;
  EXPECT_THAT(error_of(stations), AllOf(HasSubstr("x01_0007 (poses.csv:"),
                                        HasSubstr("60 mm beside the line along x from x01_0000"),
                                        HasSubstr("--line-tolerance-mm (61)")));
  EXPECT_EQ(error_of(stations, {.off_line_m = 0.062}), "no error");
  EXPECT_THAT(error_of({{"lonely", {1, 2, 3}}}),
              AllOf(HasSubstr("lonely"), HasSubstr("at least two")));
}

// Panoramas of a house, metres apart, in no order.
TEST(FindGrid, ATourIsNamed) {
  std::mt19937 random(5);
  std::vector<StationPose> stations;
  for (int i = 0; i < 32; ++i) {
    stations.push_back(
        {fmt::format("{}", i), {uniform(&random, 0.0, 12.0), 0.0, uniform(&random, 0.0, 9.0)}});
  }
  EXPECT_THAT(error_of(stations), AllOf(HasSubstr("of 32 stations"), HasSubstr("a tour")));
  EXPECT_THAT(error_of(stations, {.off_line_m = 5.6}),
              AllOf(HasSubstr("a line tolerance of 5600 mm exceeds"), HasSubstr("column line")));
}

TEST(FindGrid, StationsThatCountAsOneAreNamed) {
  std::vector<StationPose> stations = stations_of({.beyond = 1});
  stations.push_back({"again", station_of("x00_0004", &stations)->position_m, "poses.csv:99"});
  EXPECT_THAT(error_of(stations),
              AllOf(HasSubstr("again (poses.csv:99) and x00_0004 (poses.csv:6)"),
                    HasSubstr("have the same position (x = 0.3, z = 0)")));
  stations.back().position_m.x() += 0.001;
  EXPECT_EQ(error_of(stations), "no error");
  EXPECT_THAT(error_of(stations, {.same_station_m = 0.002}), HasSubstr("are 1 mm apart"));
  EXPECT_THAT(error_of(stations, {.same_station_m = 0.02}),
              AllOf(HasSubstr("within 20 mm"), HasSubstr("10 mm off its line")));
  // A third one at an intersection.
  stations.back().position_m = station_of("x00_0001", &stations)->position_m;
  EXPECT_THAT(error_of(stations), AllOf(HasSubstr("again"), HasSubstr("the same position")));
}

TEST(FindGrid, WhatIsNoGridIsAnError) {
  EXPECT_THAT(error_of({}), HasSubstr("no stations"));
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    std::vector<StationPose> stations = stations_of({});
    stations[4].position_m.y() = bad;
    EXPECT_THAT(error_of(stations), AllOf(HasSubstr("x00_0004"), HasSubstr("not finite")));
  }
  EXPECT_THAT(error_of(stations_of({.turned_deg = 20.0})), HasSubstr("3 degrees of x or z"));
  for (const int axis : {0, 2}) {
    std::vector<StationPose> exchanged = stations_of({});
    for (StationPose& one : exchanged) std::swap(one.position_m[1], one.position_m[axis]);
    EXPECT_THAT(error_of(exchanged),
                HasSubstr(axis == 0 ? "exchanged with x" : "exchanged with z"));
  }
  const std::vector<StationPose> same(9, {"a", {1, 2, 3}});
  EXPECT_THAT(error_of(same), HasSubstr("at least two"));
}

// The height of a line at `along_m`, of stations 25 cm apart.
std::string error_of_heights(const std::function<double(double)>& height_m) {
  std::vector<StationPose> stations;
  for (int i = 0; i < 40; ++i) {
    stations.push_back({fmt::format("{:02}", i), {0.25 * i, height_m(0.25 * i), 0.0}});
  }
  return error_of(stations);
}

TEST(FindGrid, LinesGoUpAndDownHillButNotOverSteps) {
  EXPECT_EQ(error_of_heights([](double x) { return 0.1 * std::sin(kTwoPi * x / 8.0); }),
            "no error");
  EXPECT_EQ(error_of_heights([](double x) { return 0.1 * x; }), "no error");
  EXPECT_THAT(error_of_heights([](double x) { return x == 5.0 ? -0.3 : 0.0; }),
              AllOf(HasSubstr("20 is 300 mm below"), HasSubstr("tolerance of 25 mm")));
  EXPECT_THAT(error_of_heights([](double x) { return x < 5.0 ? 0.0 : 0.3; }), HasSubstr("150 mm"));
  EXPECT_THAT(error_of_heights([](double x) { return 0.2 * x; }),
              AllOf(HasSubstr("climbs by 11.3 degrees"), HasSubstr("more than 6")));
}

// The border of the whole grid, typed as planned, is inside; a tenth of a micrometre outside is
// not.
TEST(FindCell, BordersAreInside) {
  for (const double x_m : {0.0, -100.0, 12345.678, -99999.9}) {
    const GridCase plan{.columns = 3, .rows = 2, .spacing_m = 0.1 / 3.0, .corner = {x_m, 7.7}};
    const Grid grid = find_grid(stations_of(plan), {});
    EXPECT_TRUE(find_cell(grid, {x_m + 1.0, 7.7}));
    EXPECT_FALSE(find_cell(grid, {x_m + 1.0 + 1e-7, 7.7}));
    EXPECT_EQ(find_cell(grid, {x_m + 0.5, 8.0}), 1);
    EXPECT_FALSE(find_cell(grid, {std::nan(""), 8.0}));
  }
}

// By its definition, over gaps whose sums are exact.
TEST(CoveringSpacing, HalfOfTheLineLiesInGapsAtLeastAsLarge) {
  EXPECT_EQ(covering_spacing({0.3}), 0.3);
  EXPECT_EQ(covering_spacing({0.005, 0.045, 0.005, 0.045, 0.005}), 0.045);
  EXPECT_EQ(covering_spacing({0.05, 0.05, 2.0, 0.05}), 0.05);
  std::mt19937 random(4);
  for (int round = 0; round < 500; ++round) {
    std::vector<double> gaps_m(2 + random() % 60);
    for (double& gap_m : gaps_m) {
      gap_m = std::ldexp(static_cast<double>(random() % 10), 3 - static_cast<int>(random() % 16));
    }
    std::vector<double> descending_m = gaps_m;
    std::ranges::sort(descending_m, std::greater());
    const double middle_m = descending_m[(descending_m.size() - 1) / 2];
    descending_m.erase(descending_m.begin());
    double half_m = 0.0, sum_m = 0.0, at_half_m = 0.0;
    for (const double gap_m : descending_m) half_m += 0.5 * gap_m;
    for (std::size_t i = 0; i == 0 || sum_m < half_m; ++i) sum_m += at_half_m = descending_m[i];
    EXPECT_EQ(covering_spacing(gaps_m), std::max(middle_m, at_half_m)) << round;
  }
}

TEST(LineNotes, NameTheSideThatACellLacks) {
  std::vector<StationPose> stations;
  add_line("front", LineAxis::kX, -0.65, 0.5, 14, &stations);
  add_line("left", LineAxis::kZ, -0.5, -0.65, 14, &stations);
  add_line("right", LineAxis::kZ, 0.5, -0.65, 14, &stations);
  EXPECT_THAT(
      line_notes(find_grid(stations, {})),
      ElementsAre(HasSubstr("x0, z0 and z1 are three sides of a cell; the fourth, along x "
                            "from about -0.5,-0.5 to 0.5,-0.5 (x,z in metres), is missing")));
  add_line("back", LineAxis::kX, -0.65, -0.5, 8, &stations);
  EXPECT_THAT(
      line_notes(find_grid(stations, {})),
      ElementsAre(HasSubstr("line x0 ends 450 mm before the corner with line z1 at 0.5,-0.5")));
  add_line("rest", LineAxis::kX, 0.15, -0.5, 6, &stations);
  EXPECT_TRUE(line_notes(find_grid(stations, {})).empty());
}

TEST(DoubtOfUnit, MillimetresAreNotMetres) {
  EXPECT_FALSE(doubt_of_unit(find_grid(stations_of({}), {})));
  EXPECT_FALSE(doubt_of_unit(find_grid(stations_of({.spacing_m = 1.5}), {}))) << "a hall";
  const auto doubt = doubt_of_unit(find_grid(stations_of({.spacing_m = 100.0}), {}));
  ASSERT_TRUE(doubt);
  EXPECT_THAT(*doubt, AllOf(HasSubstr("100 m apart"), HasSubstr("1000 m wide"),
                            HasSubstr("divide millimetres by 1000")));
  const GridCase dense{.steps = 100, .spacing_m = 1.0};
  EXPECT_TRUE(doubt_of_unit(find_grid(stations_of(dense), {})));
}

}  // namespace
}  // namespace raywalk
