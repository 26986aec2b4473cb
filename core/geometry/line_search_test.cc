// What does not change the lines that find_grid finds: the place, size and order of the stations.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <string>

#include "core/geometry/grid.h"

namespace raywalk {
namespace {

using Files = std::set<std::string>;

double uniform(std::mt19937* random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(*random);
}

// Lines x = 0, 1 and z = 0, 1 and 2 of a grid of unit cells, 5 to 15 cm between stations, each line
// captured once or twice, with stations up to `off_m` beside and above their line. Files are named
// after their line.
std::vector<StationPose> handheld_grid(unsigned seed, double off_m) {
  std::mt19937 random(seed);
  std::vector<StationPose> stations;
  const auto add_line = [&](const std::string& name, bool along_x, double across_m, double end_m) {
    const int passes = 1 + static_cast<int>(random() % 2);
    int frame = 0;
    for (int pass = 0; pass < passes; ++pass) {
      for (double along_m = -uniform(&random, 0.1, 0.3); along_m < end_m + 0.2;
           along_m += uniform(&random, 0.05, 0.15)) {
        const double off = across_m + uniform(&random, -off_m, off_m);
        const double height = uniform(&random, -off_m, off_m);
        stations.push_back({fmt::format("{}_{:03}.jpg", name, frame++),
                            along_x ? Eigen::Vector3d(along_m, height, off)
                                    : Eigen::Vector3d(off, height, along_m),
                            ""});
      }
    }
  };
  for (int z = 0; z <= 2; ++z) add_line(fmt::format("x{}", z), true, z, 1.0);
  for (int x = 0; x <= 1; ++x) add_line(fmt::format("z{}", x), false, x, 2.0);
  return stations;
}

std::set<Files> lines_of(const Grid& grid) {
  std::set<Files> lines;
  for (const Line& line : grid.lines) {
    Files files;
    for (const Station& station : line.stations) files.insert(station.file);
    lines.insert(files);
  }
  return lines;
}

std::string name_of_line(const std::string& file) { return file.substr(0, 2); }

// The stations that are on one line only, by the distances from the true lines.
bool is_at_crossing(const StationPose& station, double reach_m) {
  const double x = station.position_m.x(), z = station.position_m.z();
  return std::abs(x - std::round(x)) <= reach_m && std::abs(z - std::round(z)) <= reach_m;
}

TEST(FindLines, HandheldLinesAreFoundAndStationsAreWithTheirOwn) {
  for (const double off_m : {0.0, 0.01, 0.03, 0.06}) {
    for (unsigned seed = 0; seed < 20; ++seed) {
      const std::vector<StationPose> stations = handheld_grid(seed, off_m);
      const Grid grid = find_grid(stations, {.off_line_m = off_m + 0.02, .same_station_m = 1e-9});
      ASSERT_EQ(grid.lines.size(), 5U) << off_m << ' ' << seed;
      EXPECT_EQ(grid.cells.size(), 2U) << off_m << ' ' << seed;
      std::set<std::string> at_crossings;
      for (const StationPose& station : stations) {
        if (is_at_crossing(station, 2.0 * off_m + 0.05)) at_crossings.insert(station.file);
      }
      for (const Line& line : grid.lines) {
        Files names;
        for (const Station& station : line.stations) {
          if (!at_crossings.contains(station.file)) names.insert(name_of_line(station.file));
        }
        EXPECT_EQ(names.size(), 1U) << off_m << ' ' << seed << ' ' << line.id;
      }
    }
  }
}

TEST(FindLines, TheOrderOfTheListDoesNotMatter) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::vector<StationPose> stations = handheld_grid(seed, 0.05);
    const auto expected =
        lines_of(find_grid(stations, {.off_line_m = 0.07, .same_station_m = 1e-9}));
    for (unsigned order = 0; order < 5; ++order) {
      std::shuffle(stations.begin(), stations.end(), std::mt19937(order));
      EXPECT_EQ(lines_of(find_grid(stations, {.off_line_m = 0.07, .same_station_m = 1e-9})),
                expected)
          << seed;
    }
  }
}

TEST(FindLines, MovedTurnedAndScaledStationsGiveTheSameLines) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const std::vector<StationPose> stations = handheld_grid(seed, 0.03);
    const auto expected =
        lines_of(find_grid(stations, {.off_line_m = 0.05, .same_station_m = 1e-9}));
    for (const double scale : {1e-3, 1.0, 1e5}) {
      std::mt19937 random(seed);
      const double turn_rad = std::round(uniform(&random, 0.0, 3.0)) * kHalfPi +
                              radians_from_degrees(uniform(&random, -1.5, 1.5));
      const Eigen::Vector3d shift(uniform(&random, -10.0, 10.0), uniform(&random, -10.0, 10.0),
                                  uniform(&random, -10.0, 10.0));
      std::vector<StationPose> moved = stations;
      for (StationPose& station : moved) {
        const Eigen::Vector3d at = station.position_m;
        station.position_m = {std::cos(turn_rad) * at.x() - std::sin(turn_rad) * at.z(), at.y(),
                              std::sin(turn_rad) * at.x() + std::cos(turn_rad) * at.z()};
        station.position_m = scale * (station.position_m + shift);
      }
      const Grid grid =
          find_grid(moved, {.off_line_m = 0.05 * scale, .same_station_m = 1e-9 * scale});
      EXPECT_EQ(lines_of(grid), expected) << seed << " x " << scale;
      EXPECT_EQ(grid.cells.size(), 2U);
    }
  }
}

// Two passes of a square with 5 cm between stations of a pass, the second one `ahead_m` ahead and
// `beside_m` beside the first.
std::vector<StationPose> two_passes(double ahead_m, double beside_m) {
  std::vector<StationPose> stations;
  for (int pass = 0; pass < 2; ++pass) {
    for (int line = 0; line < 4; ++line) {
      for (int i = 0; i < 31; ++i) {
        const double along_m = -0.75 + i * 0.05 + pass * ahead_m;
        const double across_m = (line % 2 == 0 ? -0.5 : 0.5) + pass * beside_m;
        stations.push_back({fmt::format("line{}_pass{}_{:02}.jpg", line, pass, i),
                            line < 2 ? Eigen::Vector3d(along_m, 0.0, across_m)
                                     : Eigen::Vector3d(across_m, 0.0, along_m),
                            ""});
      }
    }
  }
  return stations;
}

TEST(FindLines, TwoPassesOfALineAreOneLine) {
  for (const double ahead_m : {0.0, 1e-4, 0.001, 0.003, 0.005, 0.012, 0.025, 0.04, 0.0499}) {
    for (const double beside_m : {0.0, 1e-4, 0.002, 0.005, 0.01, 0.02}) {
      if (ahead_m == 0.0 && beside_m < 0.001) continue;  // counts as one
      const Grid grid =
          find_grid(two_passes(ahead_m, beside_m), {.off_line_m = 0.02, .same_station_m = 5e-5});
      ASSERT_EQ(grid.lines.size(), 4U) << ahead_m << ' ' << beside_m;
      EXPECT_EQ(grid.cells.size(), 1U) << ahead_m << ' ' << beside_m;
      for (const Line& line : grid.lines) {
        EXPECT_NEAR(static_cast<double>(line.stations.size()), 62.0, 4.0);
        for (std::size_t i = 1; i < line.stations.size(); ++i) {
          EXPECT_GT(line.stations[i].along_m, line.stations[i - 1].along_m);
        }
      }
    }
  }
}

TEST(FindLines, TwoPassesNeedNoOptions) {
  for (const double ahead_m : {0.005, 0.025, 0.045}) {
    const Grid grid = find_grid(two_passes(ahead_m, 0.003), {});
    EXPECT_EQ(grid.lines.size(), 4U) << ahead_m;
    EXPECT_EQ(grid.cells.size(), 1U) << ahead_m;
  }
}

}  // namespace
}  // namespace raywalk
