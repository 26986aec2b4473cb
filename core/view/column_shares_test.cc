#include "core/view/column_shares.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/view/test_points.h"
#include "core/view/test_room.h"
#include "core/view/test_steps.h"

namespace raywalk {
namespace {

constexpr PlanPoint kSharesAt{-0.1, -0.2};
const ViewOptions kTwoSidedShares{.generation = Generation::kTwoSided, .width = 256};

TEST(ColumnShares, AddUpToOneWhereverALineSeesARow) {
  int hidden = 0;
  int shared = 0;
  for (const ViewOptions& options :
       {kTwoSidedShares, ViewOptions{.overlap_deg = 45.0, .width = 256}}) {
    PreparedSteps prepared(pillar_room().room(), options, kSharesAt);
    for (int u = 0; u < 256; ++u) {
      const auto sources = prepared.sources(u);
      if (sources.size() < 2) continue;
      const ColumnPoints& points = prepared.steps.distances.prepare(u);
      const ColumnShares& shares = prepared.steps.weights.weigh(points, sources);
      for (size_t row = 0; row < shares.hidden.size(); ++row) {
        int sum = 0;
        for (size_t i = 0; i < sources.size(); ++i) sum += shares.weights[i][row];
        if (shares.hidden[row] == kSeen) {
          ASSERT_EQ(sum, 0) << u << ", " << row;
          ASSERT_TRUE(shares.any_hidden);
          ++hidden;
        } else {
          // Each share is rounded down.
          ASSERT_LE(sum, 32767) << u << ", " << row;
          ASSERT_GT(sum, 32767 - static_cast<int>(sources.size())) << u << ", " << row;
          ++shared;
        }
      }
    }
  }
  EXPECT_GT(hidden, 10);
  EXPECT_GT(shared, 256 * 64);
}

// Whether the acquisition point of a source sees a pixel of the distances; none at a silhouette.
std::optional<bool> line_sees(const PreparedSteps& prepared, const ColumnPoints& points,
                              const RaySource& source, int row) {
  return all_seen(pillar_room().spec().scene, prepared.view,
                  acquisition_point(prepared.view, source, points.theta_rad), points.depth_theta,
                  row);
}

TEST(ColumnShares, ALineThatAPillarHidesAPointFromHasNoShare) {
  PreparedSteps prepared(pillar_room().room(), kTwoSidedShares, kSharesAt);
  int occluded = 0;
  int wrong = 0;
  for (int u = 0; u < 256; ++u) {
    const auto sources = prepared.sources(u);
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    const ColumnShares& shares = prepared.steps.weights.weigh(points, sources);
    for (int row = 0; row < 64; ++row) {
      for (size_t i = 0; i < sources.size(); ++i) {
        if (line_sees(prepared, points, sources[i], row).value_or(true)) continue;
        ++occluded;
        wrong += shares.weights[i][static_cast<size_t>(row)] == 0 ? 0 : 1;
      }
    }
  }
  EXPECT_GT(occluded, 100);
  EXPECT_LE(wrong, occluded / 20);
}

TEST(ColumnShares, WhatNoLineSeesIsHidden) {
  PreparedSteps prepared(pillar_room().room(), {.overlap_deg = 0.0, .width = 256}, kSharesAt);
  int occluded = 0;
  int wrong = 0;
  for (int u = 0; u < 256; ++u) {
    const auto sources = prepared.sources(u);
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    const ColumnShares& shares = prepared.steps.weights.weigh(points, sources);
    for (int row = 0; row < 64; ++row) {
      if (line_sees(prepared, points, sources.front(), row).value_or(true)) continue;
      ++occluded;
      wrong += shares.hidden[static_cast<size_t>(row)] == kSeen ? 0 : 1;
    }
  }
  EXPECT_GT(occluded, 100);
  EXPECT_LE(wrong, occluded / 20);
}

TEST(ColumnShares, LinesShareInInverseProportionToTheirDistance) {
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), kTwoSidedShares, {0.0, 0.3});
  int columns = 0;
  for (int u = 0; u < 256; ++u) {
    const auto sources = prepared.sources(u);
    if (sources.size() != 2) continue;
    const ColumnShares& shares =
        prepared.steps.weights.weigh(prepared.steps.distances.prepare(u), sources);
    const double front_m = std::fabs(sources[0].d_p_m);
    const double behind_m = std::fabs(sources[1].d_p_m);
    EXPECT_FALSE(shares.any_hidden);
    for (size_t row = 0; row < shares.hidden.size(); ++row) {
      ASSERT_NEAR(shares.weights[0][row] / 32767.0, behind_m / (front_m + behind_m), 1e-3) << u;
    }
    ++columns;
  }
  EXPECT_GT(columns, 100);
}

TEST(ColumnShares, ALineThroughTheViewpointIsUsedAlone) {
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), kTwoSidedShares, {0.0, 0.4999});
  const int ahead = 128;
  const auto sources = prepared.sources(ahead);
  ASSERT_EQ(sources.size(), 2U);
  ASSERT_LT(std::fabs(sources[0].d_p_m), 0.001);
  const ColumnShares& shares =
      prepared.steps.weights.weigh(prepared.steps.distances.prepare(ahead), sources);
  for (const int weight : shares.weights[0]) ASSERT_GT(weight, 32750);
}

TEST(ColumnShares, ASingleLineIsNeededWhereItSees) {
  const TestRoom& room = pillar_room();
  PreparedSteps prepared(room.room(), {.overlap_deg = 0.0, .width = 256}, kSharesAt);
  int unseen = 0;
  for (int u = 0; u < 256; ++u) {
    const auto sources = prepared.sources(u);
    ASSERT_EQ(sources.size(), 1U);
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    const ColumnShares& shares = prepared.steps.weights.weigh(points, sources);
    const auto seen = prepared.steps.visibility.usable_rows(points, sources[0], 0);
    ASSERT_TRUE(std::ranges::equal(shares.needed, seen)) << u;
    for (size_t row = 0; row < seen.size(); ++row) {
      ASSERT_EQ(shares.hidden[row], kSeen - seen[row]) << u << ", " << row;
      unseen += seen[row] == 0 ? 1 : 0;
    }
  }
  EXPECT_GT(unseen, 10);
}

TEST(ColumnShares, OfNoLineAllIsHidden) {
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), kTwoSidedShares, kSharesAt);
  const ColumnShares& shares = prepared.steps.weights.weigh_none();
  EXPECT_TRUE(shares.any_hidden);
  for (const int hidden : shares.hidden) EXPECT_EQ(hidden, kSeen);
}

TEST(ColumnShares, WhereHiddenTheFartherSideIsReadOnlyWhereTheNearerDoesNotSee) {
  const TestRoom& room = pillar_room();
  ViewOptions options = kTwoSidedShares;
  options.second_side = SecondSide::kWhereHidden;
  PreparedSteps prepared(room.room(), options, kSharesAt);
  std::int64_t one_side = 0;
  for (int u = 0; u < 256; ++u) {
    const auto sources = prepared.sources(u);
    if (sources.size() != 2) continue;
    const std::int64_t before = prepared.steps.weights.one_side();
    const ColumnShares& shares =
        prepared.steps.weights.weigh(prepared.steps.distances.prepare(u), sources);
    const size_t near = std::fabs(sources[0].d_p_m) <= std::fabs(sources[1].d_p_m) ? 0 : 1;
    for (size_t row = 0; row < shares.hidden.size(); ++row) {
      ASSERT_TRUE(shares.weights[near][row] == 0 || shares.weights[1 - near][row] == 0);
      one_side += shares.weights[near][row] > 0 ? 2 : 0;  // output rows per row of the distances
    }
    EXPECT_FALSE(shares.any_shared);
    one_side -= prepared.steps.weights.one_side() - before;
    ASSERT_EQ(one_side, 0) << u;
  }
  EXPECT_GT(prepared.steps.weights.one_side(), 10000);
}

}  // namespace
}  // namespace raywalk
