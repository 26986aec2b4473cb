#include "core/view/column_sources.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <utility>

#include "core/view/column_rows.h"
#include "core/view/row_map.h"
#include "core/view/test_grid.h"

namespace raywalk {
namespace {

// Of a two-sided view between a line in front and one behind.
double share_behind(double front_m, double behind_m, SecondSide second_side) {
  ColumnPlan plan;
  plan.front_count = plan.behind_count = 1;
  plan.front[0] = {.line = 0, .d_p_m = front_m};
  plan.behind[0] = {.line = 2, .d_p_m = -behind_m};
  const ColumnSources sources =
      column_sources(plan, {.method = ViewMethod::kTwoSided, .second_side = second_side});
  EXPECT_EQ(sources.count, 2U);
  EXPECT_TRUE(sources.source[1].behind());
  return sources.source[1].share;
}

TEST(ColumnSourcesProperty, SharesAddUpToOneAtAnyViewpoint) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-0.5, 0.5), k_deg(45.0, 90.0);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const Grid grid = square_grid(scale, 0.25 * scale);
    for (int view = 0; view < 60; ++view) {
      // Now and then on a line, and on a corner.
      const PlanPoint at{scale * (view % 3 == 0 ? 0.5 : place(random)),
                         scale * (view % 9 == 0 ? -0.5 : place(random))};
      const ViewPlan plan(grid, at, {radians_from_degrees(k_deg(random)), 0.2});
      const ViewOptions options{
          .method = view % 2 == 0 ? ViewMethod::kTwoSided : ViewMethod::kHlfVd,
          .second_side = view % 4 < 2 ? SecondSide::kEverywhere : SecondSide::kFaded};
      const bool both = options.method == ViewMethod::kTwoSided;
      for (int degree = 0; degree < 360; ++degree) {
        const ColumnPlan column = plan.column(radians_from_degrees(degree + 0.1));
        const ColumnSources sources = column_sources(column, options);
        ASSERT_EQ(static_cast<int>(sources.count),
                  column.front_count + (both ? column.behind_count : 0));
        double sum = 0.0;
        for (const ColumnSource& source : std::span(sources.source).first(sources.count)) {
          ASSERT_GT(source.share, 0.0f) << "what only it sees is read from it";
          sum += source.share;
        }
        ASSERT_NEAR(sum, 1.0, 2e-4);  // a side that is faded out leaves a trace
      }
    }
  }
}

TEST(ColumnSources, SidesCountByNearnessAndLinesOfABlendByTheirWeights) {
  for (const double front_m : {1e-6, 0.1, 0.5, 2.0}) {
    for (const double behind_m : {1e-6, 0.3, 1.0}) {
      EXPECT_NEAR(share_behind(front_m, behind_m, SecondSide::kEverywhere),
                  front_m / (front_m + behind_m), 2e-4);
    }
  }
  ColumnPlan plan;
  plan.front_count = 2;
  plan.front[0] = {.line = 0, .d_p_m = 0.7, .weight = 0.25};
  plan.front[1] = {.line = 1, .d_p_m = 0.7, .weight = 0.75};
  EXPECT_NEAR(column_sources(plan, {}).source[1].share, 0.75, 1e-6);
}

TEST(ColumnSources, AFadedSideGoesFromNothingToAllInTheMiddleThird) {
  double before = 0.0;
  for (double front_m = 0.0; front_m <= 1.0; front_m += 1e-3) {
    const double share = share_behind(front_m, 1.0 - front_m, SecondSide::kFaded);
    EXPECT_NEAR(share, std::clamp(3.0 * front_m - 1.0, 0.0, 1.0), 1e-3) << front_m;
    EXPECT_NEAR(share, before, 4e-3) << front_m;
    before = share;
  }
}

// The shares of all stations of an endless line add up to the number that is mixed, wherever the
// line is met: one station is cross-faded to the next.
TEST(StationShare, IsAContinuousPartition) {
  for (const StationMix mix : {StationMix{1, 0.1}, {1, 0.5}, {2, 1.0}, {7, 0.5}, {16, 0.1}}) {
    for (double met = 0.0; met < 1.0; met += 0.01) {
      double sum = 0.0;
      for (int station = -10; station <= 11; ++station) {
        const float share = station_share(station - met, mix);
        sum += share;
        EXPECT_NEAR(share, station_share(station - met + 1e-4, mix), 1.1e-4 / mix.fade);
      }
      EXPECT_NEAR(sum, mix.stations, 1e-4) << " at " << met;
    }
  }
  EXPECT_EQ(station_share(0.2, {1, 0.5}), 1.0f);
}

TEST(StationWindow, HoldsTheStationsOfTheLineThatHaveAShare) {
  for (const int stations : {2, 3, 9, 40}) {
    for (const StationMix mix : {StationMix{1, 0.1}, {1, 1.0}, {2, 0.5}, {3, 0.2}, {16, 1.0}}) {
      for (int place = 0; place <= 10 * (stations - 1); ++place) {
        const int station = std::min(place / 10, stations - 2);
        const RaySource at{.station = station, .fraction = 0.1 * place - station};
        const StationWindow window = stations_mixed(at, stations, mix);
        ASSERT_GE(window.first, 0);
        ASSERT_LE(window.first, window.last) << "there is one at the end of a line";
        ASSERT_LT(window.last, stations);
        for (int i = 0; i < stations; ++i) {
          if (i >= window.first && i <= window.last) continue;
          ASSERT_LT(station_share(i - 0.1 * place, mix), 1e-5f)
              << i << " of " << stations << ", " << mix.stations << " around " << 0.1 * place;
        }
      }
    }
  }
}

// Output rows lie between rows of the distances where their middles are.
TEST(RowMap, PlacesRowsByTheirMiddles) {
  for (const auto& [output, distances] : {std::pair{64, 64}, {96, 64}, {64, 96}, {7, 5}, {8, 1}}) {
    const RowMap map(output, distances);
    for (std::size_t i = 0; i < static_cast<std::size_t>(output); ++i) {
      const double at = (static_cast<double>(i) + 0.5) * distances / output - 0.5;
      EXPECT_NEAR(map.nearest[i] + double(map.down[i]), at, 1e-6);
      EXPECT_LE(std::fabs(map.nearest[i] - at), 0.5 + 1e-9);
      const auto nearest = static_cast<std::size_t>(map.nearest[i]);
      EXPECT_GE(static_cast<int>(i), map.first[nearest]);
      EXPECT_LT(static_cast<int>(i), map.first[nearest + 1]);
    }
    EXPECT_EQ(map.first.front(), 0);
    EXPECT_EQ(map.first.back(), output);
  }
}

// Linear within a surface, the nearest row's across a step and where a station's columns jump.
TEST(InterpolateRows, JoinsWhatIsOneSurface) {
  constexpr int kRows = 9;
  for (const int per_row : {1, 2, 3, 4, 8}) {
    const RowMap map(kRows * per_row, kRows);
    std::array<float, kRows + 2> at{}, joined{};
    for (std::size_t i = 0; i < at.size(); ++i) {
      at[i] = i < 7 ? 3.0f * static_cast<float>(i) : 500.0f;
      joined[i] = i == 4 ? 0.0f : 1.0f;  // a step between rows 3 and 4, a jump after row 5
    }
    std::array<float, 8 * kRows> out{}, general{};
    const RowsBetween rows{map.nearest.data(), map.down.data(), map.per_row(), kRows * per_row};
    interpolate_rows(at.data() + 1, joined.data() + 1, rows, 100.0f, out.data());
    interpolate_rows(at.data() + 1, joined.data() + 1, {rows.nearest, rows.down, 0, rows.rows},
                     100.0f, general.data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(rows.rows); ++i) {
      const auto row = static_cast<std::size_t>(map.nearest[i]) + 1;
      const double down = map.down[i];
      const bool apart = down < 0.0 ? row == 5 || row == 7 : row == 4 || row == 6;
      const double beside = down < 0.0 ? at[row - 1] : at[row + 1];
      const double truth = at[row] + (apart ? 0.0 : std::fabs(down) * (beside - at[row]));
      EXPECT_NEAR(general[i], truth, 1e-4) << i << " of " << rows.rows;
      EXPECT_NEAR(out[i], truth, 1e-4) << i << " of " << rows.rows;
    }
  }
}

}  // namespace
}  // namespace raywalk
