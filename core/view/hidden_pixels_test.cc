#include "core/view/hidden_pixels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/view/test_points.h"
#include "core/view/test_room.h"
#include "core/view/test_steps.h"

namespace raywalk {
namespace {

constexpr PlanPoint kHiddenAt{-0.1, -0.15};
constexpr int kHiddenRows = 128;
constexpr std::uint8_t kNotFilled = 3;

bool sees_all(const SyntheticScene& scene, const ViewInputs& view, const MapStation& map,
              int depth_theta, int depth_row) {
  return all_seen(scene, view, map.position_m, depth_theta, depth_row).value_or(false);
}

TEST(FillStations, AStationIsChosenThatSeesThePoint) {
  const TestRoom& room = pillar_room();
  PreparedSteps prepared(room.room(), {.width = 256}, kHiddenAt);
  const SyntheticScene& scene = room.spec().scene;
  int decided = 0;
  int blind = 0;
  int nearer_blind = 0;  // pixels that the nearest station does not show
  for (int theta = 0; theta < 128; ++theta) {
    for (int row = 0; row < 64; ++row) {
      const int chosen = prepared.steps.fill.of(theta, row);
      if (chosen == FillStations::kNone) continue;
      const auto seen =
          all_seen(scene, prepared.view,
                   prepared.view.fill_maps[static_cast<size_t>(chosen)].position_m, theta, row);
      if (!seen) continue;
      ++decided;
      blind += *seen ? 0 : 1;
      nearer_blind += chosen > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(decided, 6000);
  EXPECT_GT(nearer_blind, 50);
  EXPECT_LE(blind, 5);
}

// Whether the distance of a pixel is that of the room.
bool has_true_distance(const SyntheticScene& scene, const ViewInputs& view, int depth_theta,
                       int depth_row) {
  const Eigen::Vector3d from = view.viewpoint_m();
  const Eigen::Vector3d point =
      point_at(scene, from, {double(depth_theta), double(depth_row)}, view.distances->size());
  const double omega = view.distances->column(depth_theta)[depth_row];
  return std::fabs(omega * (point - from).norm() - 1.0) < 0.02;
}

TEST(FillStations, NoneIsChosenOnlyWhereNoneSeesThePoint) {
  const TestRoom& room = pillar_room();
  // Beside the pillar, which hides much from the one station that may fill.
  PreparedSteps prepared(room.room(), {.width = 256, .fill_stations = 1}, {0.05, 0.13});
  ASSERT_EQ(prepared.view.fill_maps.size(), 1U);
  const MapStation& map = prepared.view.fill_maps.front();
  const SyntheticScene& scene = room.spec().scene;
  int none = 0;
  int wrong = 0;
  for (int theta = 0; theta < 128; ++theta) {
    for (int row = 0; row < 64; ++row) {
      if (prepared.steps.fill.of(theta, row) != FillStations::kNone) continue;
      if (!has_true_distance(scene, prepared.view, theta, row)) continue;
      ++none;
      wrong += sees_all(scene, prepared.view, map, theta, row) ? 1 : 0;
    }
  }
  EXPECT_GT(none, 100);
  EXPECT_LE(wrong, none / 50);
}

TEST(HiddenPixels, AreShownByAStationThatSeesThem) {
  const TestRoom& room = pillar_room();
  PreparedSteps prepared(room.room(), {.width = 256}, kHiddenAt);
  const SyntheticScene& scene = room.spec().scene;
  int shown = 0;
  double difference = 0.0;
  for (int u = 0; u < 256; ++u) {
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    const std::vector<std::uint8_t> hidden =
        prepared.steps.weights.weigh(points, prepared.sources(u)).hidden;
    std::vector<std::uint8_t> rgb(3 * kHiddenRows + 1, kNotFilled);
    prepared.steps.hidden.fill(points, hidden, rgb.data());
    for (int row = 0; row < kHiddenRows; ++row) {
      const auto depth_row = static_cast<size_t>(row / 2);
      const auto first = static_cast<size_t>(3 * row);
      if (hidden[depth_row] == 0) {
        ASSERT_EQ(rgb[first], kNotFilled) << "a seen row was written: " << u << ", " << row;
        continue;
      }
      const int chosen = prepared.steps.fill.of(points.depth_theta, row / 2);
      if (chosen == FillStations::kNone ||
          !sees_all(scene, prepared.view, prepared.view.fill_maps[static_cast<size_t>(chosen)],
                    points.depth_theta, row / 2)) {
        continue;
      }
      const Eigen::Vector3d truth =
          color_at(scene, prepared.view.viewpoint_m(),
                   direction_from_angles(angles_from_pixel({double(u), double(row)}, {256, 128})));
      for (size_t c = 0; c < 3; ++c) {
        difference += std::fabs(rgb[first + c] - truth[static_cast<Eigen::Index>(c)]);
      }
      ++shown;
    }
  }
  EXPECT_GT(shown, 100);
  EXPECT_LT(difference / (3.0 * shown), 3.0);
  EXPECT_GE(prepared.steps.hidden.filled(), shown);
}

TEST(HiddenPixels, AHalfHiddenRowIsHalfFilled) {
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), {.width = 256}, kHiddenAt);
  const ColumnPoints& points = prepared.steps.distances.prepare(60);
  const auto fill = [&](std::uint8_t part) {
    std::vector<std::uint8_t> rgb(3 * kHiddenRows + 1, 0);
    EXPECT_TRUE(prepared.steps.hidden.fill(points, std::vector<std::uint8_t>(64, part), rgb.data())
                    .empty());
    return rgb;
  };
  const auto all = fill(kSeen);
  const auto half = fill(kSeen / 2);
  for (size_t i = 0; i < 3 * kHiddenRows; ++i) ASSERT_NEAR(half[i], 0.5 * all[i], 1.0);
}

TEST(HiddenPixels, RowsThatNoStationShowsAreLeftAndStretchedFromTheFartherNeighbour) {
  const TestRoom& room = pillar_room();
  PreparedSteps prepared(room.room(), {.width = 256, .fill_stations = 0}, kHiddenAt);
  ASSERT_TRUE(prepared.view.fill_maps.empty());
  ColumnPoints points = prepared.steps.distances.prepare(60);
  std::vector<float> omega(64, 0.5f);
  omega[20] = 0.4f;  // above the first run: farther than below
  omega[40] = 0.4f;  // below the second run
  points.depth_omega = omega;
  std::vector<std::uint8_t> hidden(64, 0);
  for (size_t row = 21; row < 25; ++row) hidden[row] = kSeen;
  for (size_t row = 35; row < 40; ++row) hidden[row] = kSeen;
  std::vector<std::uint8_t> rgb(3 * kHiddenRows + 1);
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<std::uint8_t>(i / 3);
  const auto before = rgb;

  HiddenPixels& pixels = prepared.steps.hidden;
  const auto unresolved = pixels.fill(points, hidden, rgb.data());
  ASSERT_EQ(unresolved.size(), 2U);
  EXPECT_EQ(unresolved[0], (RowRun{42, 50}));
  EXPECT_EQ(unresolved[1], (RowRun{70, 80}));
  EXPECT_EQ(rgb, before);
  EXPECT_EQ(pixels.filled(), 0);

  std::vector<int> rendered;
  const auto render_row = [&](int row) { rendered.push_back(row); };
  // Row 80 is not rendered yet.
  EXPECT_TRUE(pixels.stretch(points, {0, 80}, render_row, rgb.data()));
  EXPECT_EQ(rendered, std::vector<int>{80});
  for (int row = 0; row < kHiddenRows; ++row) {
    const bool first = row >= 42 && row < 50;
    const bool second = row >= 70 && row < 80;
    const int expected = first ? 41 : second ? 80 : row;
    ASSERT_EQ(rgb[static_cast<size_t>(3 * row)], expected) << row;
  }
  EXPECT_EQ(pixels.stretched(), 18);
}

}  // namespace
}  // namespace raywalk
