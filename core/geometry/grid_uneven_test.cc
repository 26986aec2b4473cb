// Captures that are not a slider's: uneven spacing, stations beside their line, hills, repeated
// stations; and what find_grid says of those it cannot place.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/grid.h"
#include "core/geometry/line_gaps.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

StationPose at(const std::string& file, double x_m, double z_m, double y_m = 0.0) {
  return {file, {x_m, y_m, z_m}, ""};
}

// A vehicle's two passes of a street along z: up to 17 cm beside its line, up and down by 30 cm,
// 0.1 to 3 m between stations.
std::vector<StationPose> street() {
  return {at("483", 0.0917, -17.0772, -0.1852), at("722", -0.0129, -15.5469, -0.1652),
          at("484", 0.0278, -13.4002, -0.1252), at("723", -0.0876, -11.5784, -0.0952),
          at("485", 0.0501, -10.5491, -0.0652), at("724", -0.1026, -8.2479, -0.0452),
          at("486", 0.0739, -6.8496, -0.0052),  at("725", -0.0725, -4.2344, 0.0248),
          at("487", 0.0684, -3.7298, 0.0548),   at("726", -0.0792, -0.9633, 0.0848),
          at("488", 0.0648, -0.3371, 0.1048),   at("727", -0.1188, 2.0405, 0.1048),
          at("489", 0.0793, 2.1392, 0.1148),    at("728", -0.1806, 5.3443, 0.0648),
          at("490", 0.1103, 5.8599, 0.0748),    at("491", 0.1399, 8.8735, 0.0548),
          at("729", -0.1392, 9.3492, 0.0348),   at("730", -0.0929, 12.9611, 0.0048),
          at("492", 0.1608, 13.2392, 0.0148),   at("731", -0.1150, 16.2704, -0.0352),
          at("493", 0.1342, 16.4368, -0.0152)};
}

std::string message_of(const std::vector<StationPose>& stations, GridTolerance tolerance = {}) {
  try {
    find_grid(stations, tolerance);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(FindGridUneven, StationsNearerThanTheLineToleranceAreTwo) {
  for (const double tolerance_m : {0.2, 0.25, 0.5, 1.0, 2.0}) {
    const Grid grid = find_grid(street(), {.off_line_m = tolerance_m});
    ASSERT_EQ(grid.lines.size(), 1U) << tolerance_m;
    EXPECT_EQ(grid.lines[0].stations.size(), 21U) << tolerance_m;
    EXPECT_EQ(grid.lines[0].axis, LineAxis::kZ);
  }
}

TEST(FindGridUneven, StationTooFarBesideItsLineIsNamedWithLineDistanceAndTolerance) {
  std::vector<StationPose> stations = street();
  stations[13].position_m.x() = -0.6;  // 728
  EXPECT_THAT(message_of(stations, {.off_line_m = 0.25}),
              AllOf(HasSubstr("728 at x = -0.6, z = 5.3443 is 60"),
                    HasSubstr("mm beside the line along z from 483 to 493 (20 stations), more than "
                              "the line tolerance of 250 mm"),
                    HasSubstr("--line-tolerance-mm 6")));
}

TEST(FindGridUneven, StationsWithinTheSameStationDistanceAreNamedWithTheirDistance) {
  EXPECT_THAT(
      message_of(street(), {.off_line_m = 0.25, .same_station_m = 0.23}),
      AllOf(HasSubstr("727 and 489 are 221 mm apart"),
            HasSubstr("stations within 230 mm count as one"), HasSubstr("--same-station-mm")));
}

TEST(FindGridUneven, SameStationDistanceAboveTheLineToleranceIsAnError) {
  EXPECT_THAT(message_of(street(), {.off_line_m = 0.25, .same_station_m = 0.3}),
              AllOf(HasSubstr("within 300 mm"), HasSubstr("250 mm off its line")));
}

// Each corner is the place of two stations, one of each line, a little apart.
std::vector<StationPose> square_apart(double apart_m) {
  std::vector<StationPose> stations;
  for (const double across_m : {-0.5, 0.5}) {
    for (int i = 0; i <= 20; ++i) {
      const double along_m = -0.5 + i * 0.05;
      stations.push_back(at(fmt::format("x{}_{:02}", across_m, i), along_m, across_m));
    }
    for (int i = 0; i <= 20; ++i) {
      const double along_m = -0.5 + i * 0.05;
      stations.push_back(
          at(fmt::format("z{}_{:02}", across_m, i), across_m + apart_m, along_m + apart_m));
    }
  }
  return stations;
}

TEST(FindGridUneven, TheTwoStationsOfACrossingNeedNotCountAsOne) {
  for (const double apart_m : {0.0, 1e-5, 1e-3, 3e-3, 0.01, 0.02}) {
    const Grid grid =
        find_grid(square_apart(apart_m), {.off_line_m = std::max(0.005, 1.5 * apart_m)});
    ASSERT_EQ(grid.lines.size(), 4U) << apart_m;
    EXPECT_EQ(grid.cells.size(), 1U) << apart_m;
    for (const Line& line : grid.lines) {
      EXPECT_EQ(line.stations.size(), 21U) << apart_m;
      for (const Station& station : line.stations) {
        EXPECT_EQ(station.file[0], line.stations[0].file[0]) << apart_m;
      }
    }
  }
}

// The tolerance takes in several stations of both lines at every corner.
TEST(FindGridUneven, ToleranceMayExceedTheSpacing) {
  for (const double tolerance_m : {0.06, 0.1, 0.15}) {
    const Grid grid = find_grid(square_apart(0.003), {.off_line_m = tolerance_m});
    ASSERT_EQ(grid.lines.size(), 4U) << tolerance_m;
    EXPECT_EQ(grid.cells.size(), 1U) << tolerance_m;
  }
}

std::vector<StationPose> line_with_heights(const std::function<double(double)>& height_m) {
  std::vector<StationPose> stations;
  for (int i = 0; i < 40; ++i) {
    stations.push_back(at(fmt::format("{:02}", i), 0.25 * i, 0.0, height_m(0.25 * i)));
  }
  return stations;
}

TEST(FindGridUneven, LineMayGoUpAndDownHill) {
  const Grid grid = find_grid(
      line_with_heights([](double x_m) { return 0.1 * std::sin(kTwoPi * x_m / 8.0); }), {});
  ASSERT_EQ(grid.lines.size(), 1U);
  for (const Station& station : grid.lines[0].stations) {
    EXPECT_EQ(station.position_m.y(), 0.1 * std::sin(kTwoPi * station.position_m.x() / 8.0));
  }
  EXPECT_EQ(message_of(line_with_heights([](double x_m) { return 0.1 * x_m; })), "no error");
}

TEST(FindGridUneven, StepsAndCliffsAreNamedWithTheirHeight) {
  EXPECT_THAT(message_of(line_with_heights([](double x_m) { return x_m == 5.0 ? -0.3 : 0.0; })),
              AllOf(HasSubstr("20 is 29"), HasSubstr("mm below"), HasSubstr("tolerance of 25 mm")));
  EXPECT_THAT(message_of(line_with_heights([](double x_m) { return x_m < 5.0 ? 0.0 : 0.3; })),
              HasSubstr("144 mm"));
  EXPECT_THAT(message_of(line_with_heights([](double x_m) { return 0.2 * x_m; })),
              AllOf(HasSubstr("climbs by 11.3 degrees"), HasSubstr("more than 6")));
}

TEST(FindGridUneven, LineAtAnAngleIsNamedAsThat) {
  std::vector<StationPose> stations;
  for (int i = 0; i < 30; ++i) {
    stations.push_back(at(fmt::format("{:02}", i), 0.05 * i, 0.05 * i * std::tan(0.1)));
  }
  EXPECT_THAT(message_of(stations), AllOf(HasSubstr("from 00 to 29 (30 stations)"),
                                          HasSubstr("turned by 5.7 degrees from x, more than 3")));
}

// Few stations beside their line do not tell its direction.
TEST(FindGridUneven, ShortLinesMayLookOblique) {
  const Grid grid =
      find_grid(std::vector{at("a", 0.0, -0.04), at("b", 0.5, 0.0), at("c", 1.0, 0.04)},
                {.off_line_m = 0.05});
  ASSERT_EQ(grid.lines.size(), 1U);
  EXPECT_NEAR(grid.lines[0].direction.z_m / grid.lines[0].direction.x_m,
              std::tan(radians_from_degrees(3.0)), 1e-12);
}

TEST(FindGridUneven, LineCloseBesideAnotherIsRatherTooFarOffIt) {
  std::vector<StationPose> stations;
  for (int i = 0; i < 20; ++i) stations.push_back(at(fmt::format("a{:02}", i), 0.05 * i, 0.0));
  for (int i = 3; i < 9; ++i) stations.push_back(at(fmt::format("b{:02}", i), 0.05 * i, 0.009));
  EXPECT_THAT(message_of(stations, {.off_line_m = 0.006}),
              AllOf(HasSubstr("b03"), HasSubstr("mm beside the line along x from a00 to a19")));
  EXPECT_EQ(find_grid(stations, {.off_line_m = 0.009}).lines.size(), 1U);
  const Grid apart = find_grid(stations, {.off_line_m = 0.004});
  EXPECT_EQ(apart.lines.size(), 2U);
  EXPECT_THAT(close_line_notes(apart), ElementsAre(AllOf(HasSubstr("x0 and x1 are 9 mm apart"),
                                                         HasSubstr("--line-tolerance-mm 9"))));
}

// Stations 2 cm apart, then 20 cm: most gaps are short.
TEST(FindGridUneven, DenseStretchDoesNotOpenTheCell) {
  std::vector<StationPose> stations = square_apart(0.0);
  for (int i = 0; i < 30; ++i) {
    stations.push_back(at(fmt::format("slow{:02}", i), -0.4305 + 0.002 * i, -0.5));
  }
  const Grid grid = find_grid(stations, {});
  EXPECT_EQ(grid.cells.size(), 1U);
  EXPECT_THAT(missing_section_notes(grid), IsEmpty());
}

TEST(FindGridUneven, MissingSectionIsNamed) {
  std::vector<StationPose> stations = square_apart(0.0);
  std::erase_if(stations, [](const StationPose& pose) {
    return pose.file > "x0.5_07" && pose.file < "x0.5_13";
  });
  EXPECT_THAT(missing_section_notes(find_grid(stations, {})),
              ElementsAre(AllOf(HasSubstr("0.3 m between x0.5_07 and x0.5_13"),
                                HasSubstr("spacing of 0.05 m"))));
}

TEST(CoveringSpacing, IgnoresShortGapsOfTwoPassesAndOneMissingSection) {
  EXPECT_EQ(covering_spacing(std::vector<double>(10, 0.05)), 0.05);
  EXPECT_EQ(covering_spacing({0.005, 0.045, 0.005, 0.045, 0.005}), 0.045);
  EXPECT_EQ(covering_spacing({0.05, 0.05, 2.0, 0.05}), 0.05);
  EXPECT_EQ(covering_spacing({0.3}), 0.3);
}

// By its definition, over gaps whose sums are exact.
TEST(CoveringSpacing, HalfOfTheLineLiesInGapsAtLeastAsLarge) {
  std::mt19937 random(4);
  for (int round = 0; round < 500; ++round) {
    std::vector<double> gaps_m(std::uniform_int_distribution<std::size_t>(2, 60)(random));
    for (double& gap_m : gaps_m) {
      gap_m = std::exp2(std::uniform_int_distribution(-12, 3)(random)) *
              std::uniform_int_distribution(0, 9)(random);
    }
    std::vector<double> descending_m = gaps_m;
    std::ranges::sort(descending_m, std::greater());
    const double middle_m = descending_m[(descending_m.size() - 1) / 2];
    descending_m.erase(descending_m.begin());
    const double half_m = std::accumulate(descending_m.begin(), descending_m.end(), 0.0) / 2;
    double sum_m = 0.0, at_half_m = 0.0;
    for (std::size_t i = 0; i == 0 || sum_m < half_m; ++i) sum_m += at_half_m = descending_m[i];
    EXPECT_EQ(covering_spacing(gaps_m), std::max(middle_m, at_half_m)) << round;
  }
}

}  // namespace
}  // namespace raywalk
