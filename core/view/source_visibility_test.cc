#include "core/view/source_visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "core/view/test_points.h"
#include "core/view/test_room.h"
#include "core/view/test_steps.h"

namespace raywalk {
namespace {

constexpr PlanPoint kVisibilityAt{-0.1, -0.15};

// What the acquisition point and both stations of a source see of a pixel of the distances: all of
// it all of them, or not; none where they disagree or at a silhouette.
std::optional<bool> source_sees(const SyntheticScene& scene, const ViewInputs& view,
                                const ColumnPoints& points, const RaySource& source, int row) {
  const std::array<Eigen::Vector3d, 3> places = {
      acquisition_point(view, source, points.theta_rad),
      station_position(view, source.line, source.station),
      station_position(view, source.line, source.station + 1)};
  int seeing = 0;
  for (const Eigen::Vector3d& place : places) {
    const std::optional<bool> seen = all_seen(scene, view, place, points.depth_theta, row);
    if (!seen) return std::nullopt;
    seeing += *seen ? 1 : 0;
  }
  if (seeing != 0 && seeing != 3) return std::nullopt;
  return seeing == 3;
}

TEST(SourceVisibility, EveryLineSeesAllOfAConvexRoom) {
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), {.generation = Generation::kTwoSided, .width = 256},
                         kVisibilityAt);
  for (int u = 0; u < 256; ++u) {
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    const auto sources = prepared.sources(u);
    for (size_t i = 0; i < sources.size(); ++i) {
      for (const int seen : prepared.steps.visibility.usable_rows(points, sources[i], i)) {
        ASSERT_EQ(seen, kSeen) << u;
      }
    }
  }
}

class VisibilityAtHeights : public testing::TestWithParam<double> {};
// Of the viewpoint above the lines; the pillar ends at 0.4 m.
INSTANTIATE_TEST_SUITE_P(Metres, VisibilityAtHeights, testing::Values(0.0, 0.1, 0.3, -0.3));

TEST_P(VisibilityAtHeights, IsThatOfTheRoomBehindAPillar) {
  const TestRoom& room = pillar_room();
  PreparedSteps prepared(room.room(), {.generation = Generation::kTwoSided, .width = 256},
                         {kVisibilityAt, GetParam()});
  int hidden = 0;
  int seen = 0;
  int wrongly_seen = 0;
  int wrongly_hidden = 0;
  for (int u = 0; u < 256; ++u) {
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    const auto sources = prepared.sources(u);
    for (size_t i = 0; i < sources.size(); ++i) {
      const auto rows = prepared.steps.visibility.usable_rows(points, sources[i], i);
      for (int row = 0; row < 64; ++row) {
        const auto truth = source_sees(room.spec().scene, prepared.view, points, sources[i], row);
        if (!truth) continue;
        const bool found = rows[static_cast<size_t>(row)] == kSeen;
        (*truth ? seen : hidden) += 1;
        if (found != *truth) (found ? wrongly_seen : wrongly_hidden) += 1;
      }
    }
  }
  EXPECT_GT(hidden, 100);
  EXPECT_GT(seen, 10000);
  EXPECT_LE(wrongly_seen, hidden / 20);
  EXPECT_LE(wrongly_hidden, seen / 200);
}

TEST(SourceVisibility, LinesAreUsedAfterAllAsFarAsDistancesAreDoubted) {
  SyntheticRoomSpec spec = pillar_spec();
  spec.stored_confidence = [](int, int) { return std::uint8_t{96}; };  // half trusted
  const TestRoom room(spec);
  PreparedSteps prepared(room.room(), {.generation = Generation::kTwoSided, .width = 256},
                         kVisibilityAt);
  int doubted = 0;
  for (int u = 0; u < 256; ++u) {
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    const float* const trust = prepared.view.distances->trust(points.depth_theta);
    const auto sources = prepared.sources(u);
    for (size_t i = 0; i < sources.size(); ++i) {
      const auto rows = prepared.steps.visibility.usable_rows(points, sources[i], i);
      for (size_t row = 0; row < rows.size(); ++row) {
        const double doubt = trust == nullptr ? 0.0 : 1.0 - trust[row];
        if (rows[row] == kSeen) continue;
        ASSERT_NEAR(rows[row], doubt * kSeen, 0.51) << u << ", " << row;
        doubted += doubt > 0.1 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(doubted, 0);
}

TEST(SourceVisibility, MaskedRaysCountAsNotSeen) {
  constexpr double kMaskedBelow_rad = -0.6;
  SyntheticRoomSpec spec = smooth_spec();
  spec.companion = CameraCompanion{
      .hides = [](const std::string& line, int station, const Eigen::Vector3d& direction) {
        // One of the two stations that are mixed.
        return line == "x1" && station % 2 == 1 && std::asin(direction.y()) < kMaskedBelow_rad;
      }};
  const TestRoom room(spec);
  PreparedSteps prepared(room.room(), {.width = 256}, kVisibilityAt);
  int masked = 0;
  int used = 0;
  for (int u = 0; u < 256; ++u) {
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    const auto sources = prepared.sources(u);
    for (size_t i = 0; i < sources.size(); ++i) {
      const std::string& id = room.room().grid().lines[static_cast<size_t>(sources[i].line)].id;
      const auto rows = prepared.steps.visibility.usable_rows(points, sources[i], i);
      for (int row = 0; row < 64; ++row) {
        const Eigen::Vector3d point =
            point_at(spec.scene, prepared.view.viewpoint_m(),
                     {double(points.depth_theta), double(row)}, prepared.view.distances->size());
        const int odd = sources[i].station + (sources[i].station % 2 == 1 ? 0 : 1);
        const double seen_at_rad =
            angles_from_direction(point - station_position(prepared.view, sources[i].line, odd))
                .phi_rad;
        constexpr double kMargin_rad = 0.06;  // a pixel of the distances and a sample's pixels
        if (std::fabs(seen_at_rad - kMaskedBelow_rad) < kMargin_rad) continue;
        const bool is_masked = id == "x1" && seen_at_rad < kMaskedBelow_rad;
        ASSERT_EQ(rows[static_cast<size_t>(row)], is_masked ? 0 : kSeen)
            << id << ", " << u << ", " << row;
        (is_masked ? masked : used) += 1;
      }
    }
  }
  EXPECT_GT(masked, 500);
  EXPECT_GT(used, 5000);
}

TEST(SourceVisibility, TheUsualReadingIsOfBothStationsOrTheNearerOne) {
  const TestRoom& room = smooth_room();
  const PreparedSteps both(room.room(), {.width = 256}, kVisibilityAt);
  const PreparedSteps one(room.room(), {.width = 256, .stations_mixed = 1}, kVisibilityAt);
  EXPECT_EQ(usual_reading(both.view, {.fraction = 0.3}), Reading::kBoth);
  EXPECT_EQ(usual_reading(one.view, {.fraction = 0.3}), Reading::kFirst);
  EXPECT_EQ(usual_reading(one.view, {.fraction = 0.7}), Reading::kSecond);
}

}  // namespace
}  // namespace raywalk
