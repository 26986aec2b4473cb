#include "core/evaluate/connect_error.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/files/test_support.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Lt;

constexpr ViewMethod kViewMethods[] = {ViewMethod::kInitial, ViewMethod::kHlfVd,
                                       ViewMethod::kTwoSided};

class ConnectErrorTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, directory_ / "room.lf");
    return Room::open(directory_ / "room.lf");
  }
  ordered_json measure(const SyntheticRoomSpec& spec, ViewMethod method,
                       const ConnectErrorOptions& options) const {
    return measure_connect_error(room_of(spec), method, options);
  }

  TestDirectory directory_;
};

// Over all k.
std::vector<double> column(const ordered_json& measured, const char* key) {
  std::vector<double> values;
  for (const ordered_json& row : measured["rows"]) values.push_back(row[key]);
  return values;
}

// Overhang that contains every overlap of 5 degrees at the centres of 4 x 4 sub-cells.
constexpr double kAmpleOverhang_m = 1.0;

TEST_F(ConnectErrorTest, LinesAgreeOnPointsAtInfinity) {
  SyntheticRoomSpec spec{.overhang_m = kAmpleOverhang_m};
  spec.scene.infinitely_far = true;
  for (const ViewMethod method : kViewMethods) {
    const ordered_json result = measure(spec, method, {.viewpoints = 3});
    EXPECT_EQ(result["rows"].size(), default_k_list_deg().size());
    EXPECT_THAT(column(result, "coverage"), Each(1.0));
    // Fixed-point weights round the same picture by at most one level.
    EXPECT_THAT(column(result, "e_connect"), Each(Lt(0.1))) << method_name(method);
  }
}

// Lines along z are exposed longer: 160 against 128 at each of the four corners.
SyntheticRoomSpec room_of_two_greys() {
  SyntheticRoomSpec spec{.overhang_m = kAmpleOverhang_m};
  spec.scene.contrast = 0.0;
  spec.line_gain = {{"z0", 1.25}, {"z1", 1.25}};
  return spec;
}

TEST_F(ConnectErrorTest, KnownDifferenceIsMeasuredExactly) {
  for (const ViewMethod method : {ViewMethod::kInitial, ViewMethod::kHlfVd}) {
    const ordered_json result = measure(room_of_two_greys(), method, {.viewpoints = 2});
    EXPECT_THAT(column(result, "e_connect"), Each(32.0 * 32.0)) << method_name(method);
    EXPECT_THAT(column(result, "e_connect_common"), Each(32.0 * 32.0));
  }
}

// In the middle of the cell the line behind is about as far away as those in front and contributes
// half of a two-sided column, the same half on both sides of the connection.
TEST_F(ConnectErrorTest, TwoSidedViewsDifferByTheLineInFrontOnly) {
  const ordered_json result =
      measure(room_of_two_greys(), ViewMethod::kTwoSided, {.viewpoints = 1});
  EXPECT_THAT(column(result, "e_connect"), Each(::testing::DoubleNear(16.0 * 16.0, 25.0)));
}

// Counts the pairs with a readable column by intersecting every ray with every line.
double counted_coverage(const SyntheticRoomSpec& spec, int viewpoints, double k_deg) {
  const double half_m = 0.5 * spec.side_m;
  const double reach_m = half_m + spec.overhang_m;
  int covered = 0;
  for (int i = 0; i < viewpoints * viewpoints; ++i) {
    const double x = ((i % viewpoints) + 0.5) / viewpoints * spec.side_m - half_m;
    const int row = i / viewpoints;
    const double z = (row + 0.5) / viewpoints * spec.side_m - half_m;
    for (const double sign_x : {-1.0, 1.0}) {
      for (const double sign_z : {-1.0, 1.0}) {
        const double to_side = half_m - sign_x * x;
        const double to_front = half_m - sign_z * z;
        const double corner_deg = degrees_from_radians(std::atan2(to_side, to_front));
        const double cut_deg = std::clamp(corner_deg, 90.0 - k_deg, k_deg);
        bool readable = false;
        for (int u = 0; u < spec.width / 4; ++u) {  // the columns of one quadrant
          const double angle_deg = (u + 0.5) * 360.0 / spec.width;
          const double slope = std::tan(radians_from_degrees(angle_deg));
          readable |= std::fabs(angle_deg - cut_deg) <= 2.5 &&
                      sign_x * x + to_front * slope <= reach_m &&
                      sign_z * z + to_side / slope <= reach_m;
        }
        covered += readable ? 1 : 0;
      }
    }
  }
  return covered / (4.0 * viewpoints * viewpoints);
}

TEST_F(ConnectErrorTest, CoverageCountsTheReadablePairs) {
  for (const double overhang_m : {0.0, 0.1, 0.25, 0.5}) {
    const SyntheticRoomSpec spec{.overhang_m = overhang_m, .width = 96, .distances = false};
    const ordered_json result = measure(spec, ViewMethod::kInitial, {.viewpoints = 7});
    for (const ordered_json& row : result["rows"]) {
      const double k_deg = row["k_deg"], coverage = row["coverage"], error = row["e_connect"];
      EXPECT_EQ(coverage, counted_coverage(spec, 7, k_deg)) << k_deg << ", " << overhang_m << " m";
      EXPECT_EQ(std::isnan(error), coverage == 0.0);
    }
  }
}

TEST_F(ConnectErrorTest, NeighbouringCellsLineServesAsOverhang) {
  const auto coverage = [&](int cells_x) {
    const SyntheticRoomSpec spec{.cells_x = cells_x, .distances = false};
    return column(measure(spec, ViewMethod::kInitial, {.viewpoints = 4, .k_list_deg = {90.0}}),
                  "coverage")[0];
  };
  EXPECT_EQ(coverage(1), 0.0);
  EXPECT_GT(coverage(2), 0.2);
}

TEST_F(ConnectErrorTest, CommonErrorIsOverThePairsOfTheMostDemandingK) {
  const SyntheticRoomSpec spec{.overhang_m = 0.25, .distances = false};
  const ordered_json result = measure(spec, ViewMethod::kInitial, {.viewpoints = 9});
  const ordered_json &lfu = result["rows"].front(), &rayspace360 = result["rows"].back();
  ASSERT_LT(lfu["coverage"], rayspace360["coverage"]);
  // Every k can read what k = 45 can read.
  EXPECT_EQ(lfu["e_connect_common"], lfu["e_connect"]);
  EXPECT_NE(rayspace360["e_connect_common"], rayspace360["e_connect"]);
  EXPECT_EQ(result["connection"]["common_share"], lfu["coverage"]);
}

TEST_F(ConnectErrorTest, CorrectionRemovesTheError) {
  const SyntheticRoomSpec spec{.overhang_m = 0.25};
  const ConnectErrorOptions options{.viewpoints = 5};
  const double initial = column(measure(spec, ViewMethod::kInitial, options), "e_connect").back();
  for (const ViewMethod method : {ViewMethod::kHlfVd, ViewMethod::kTwoSided}) {
    EXPECT_THAT(column(measure(spec, method, options), "e_connect"), Each(Lt(0.2 * initial)))
        << method_name(method);
  }
}

TEST_F(ConnectErrorTest, ThreadsDoNotChangeTheResult) {
  const Room room = room_of({.overhang_m = 0.25});
  for (const ViewMethod method : {ViewMethod::kInitial, ViewMethod::kTwoSided}) {
    set_thread_count(1);
    const ordered_json one = measure_connect_error(room, method, {.viewpoints = 4});
    set_thread_count(3);
    const ordered_json three = measure_connect_error(room, method, {.viewpoints = 4});
    set_thread_count(0);
    EXPECT_EQ(one, three);
  }
}

TEST_F(ConnectErrorTest, OptionsOutOfRangeAreUsageErrors) {
  const Room room = room_of({.distances = false});
  const ConnectErrorOptions wrong[] = {{.viewpoints = 0},
                                       {.viewpoints = 251},
                                       {.overlap_deg = 0.0},
                                       {.overlap_deg = 45.5},
                                       {.overlap_deg = std::nan("")},
                                       {.k_list_deg = {}},
                                       {.k_list_deg = {60.0, 44.9}},
                                       {.k_list_deg = {90.1}},
                                       {.k_list_deg = {std::nan("")}}};
  for (const ConnectErrorOptions& options : wrong) {
    EXPECT_THROW(measure_connect_error(room, ViewMethod::kInitial, options), UsageError);
  }
}

TEST_F(ConnectErrorTest, RoomWithoutCellsOrDistancesIsRefused) {
  EXPECT_THAT(error_of([&] { measure({.cells_z = 0}, ViewMethod::kInitial, {.viewpoints = 1}); }),
              HasSubstr("close a cell"));
  EXPECT_THAT(
      error_of([&] { measure({.distances = false}, ViewMethod::kHlfVd, {.viewpoints = 1}); }),
      HasSubstr("no distances"));
}

// 130 is no width of a view.
TEST_F(ConnectErrorTest, PanoramasOfAnyEvenWidthAreMeasured) {
  const auto error_at = [&](int width) {
    const SyntheticRoomSpec spec{.overhang_m = 0.25, .width = width};
    return column(measure(spec, ViewMethod::kInitial, {.viewpoints = 2}), "e_connect").back();
  };
  const double exact = error_at(128);
  EXPECT_NEAR(error_at(130), exact, 0.2 * exact);
}

TEST(ConnectErrorTableTest, NamesConnectionsAndHasADashForUnmeasuredErrors) {
  const double none = std::nan("");
  const auto row = [](const char* connection, double k_deg, double error, double coverage) {
    return ordered_json{{"connection", connection},
                        {"k_deg", k_deg},
                        {"method", "hlf-vd"},
                        {"e_connect", error},
                        {"e_connect_common", 0.5 * error},
                        {"coverage", coverage}};
  };
  const std::string table = connect_error_table(
      {{"connection", {{"viewpoints", 49}, {"overlap_deg", 5.0}, {"common_share", 0.25}}},
       {"rows", {row("lfu", 45.0, none, 0.0), row("hybrid", 76.0, 438.96, 0.5)}}});
  EXPECT_THAT(table, HasSubstr("hlf-vd views, 49 x 49 viewpoints"));
  EXPECT_THAT(table, ::testing::ContainsRegex("45 +lfu +- +- +0.0%\n"));
  EXPECT_THAT(table, ::testing::ContainsRegex("76 +hybrid +439.0 +219.5 +50.0%\n"));
  EXPECT_THAT(table, HasSubstr("25.0% of the corners are readable at every k\n"));
}

}  // namespace
}  // namespace raywalk
