#include "core/view/initial_columns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/view/renderer.h"
#include "core/view/test_points.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

constexpr PlanPoint kInitialAt{-0.1, -0.15};
constexpr int kInitialRows = 128;
constexpr int kInitialWidth = 2 * kInitialRows;

// The step, of an initial view of the panoramas' size.
struct InitialStep {
  explicit InitialStep(const Room& room, int width = kInitialWidth)
      : renderer(room, {.generation = Generation::kInitial, .width = width}),
        view(renderer.prepare(kInitialAt).inputs()),
        reader(view.room, view.interpolation, view.touched, view.gains),
        positions(view),
        columns(view, positions, reader),
        rgb(3 * static_cast<size_t>(view.output.height) + 1) {}

  std::vector<RaySource> sources(int u) const {
    const double theta_rad = angles_from_pixel({double(u), 0.0}, view.output).theta_rad;
    return renderer.sources(view.plan.column(theta_rad));
  }

  Renderer renderer;
  const ViewInputs& view;
  SampleReader reader;
  StationPositions positions;
  InitialColumns columns;
  std::vector<std::uint8_t> rgb;
};

// Column `u` of the stations around the acquisition points, mixed by nearness.
std::vector<double> mixed_columns(const ViewInputs& view, const std::vector<RaySource>& sources,
                                  int u) {
  std::vector<double> mixed(3 * kInitialRows);
  for (const RaySource& source : sources) {
    for (int next = 0; next < 2; ++next) {
      const double share = source.weight * (next == 0 ? 1.0 - source.fraction : source.fraction);
      const auto column = view.room.volume(source.line).column(source.station + next, u);
      for (size_t i = 0; i < mixed.size(); ++i) mixed[i] += share * column[i];
    }
  }
  return mixed;
}

TEST(InitialColumns, AreTheStoredColumnsMixedByNearness) {
  InitialStep step(pillar_room().room());
  int connected = 0;
  for (int u = 0; u < kInitialWidth; ++u) {
    const auto sources = step.sources(u);
    connected += sources.size() > 1 ? 1 : 0;
    EXPECT_TRUE(step.columns.render(u, sources, step.rgb.data()).empty());
    const auto expected = mixed_columns(step.view, sources, u);
    for (size_t i = 0; i < expected.size(); ++i) ASSERT_NEAR(step.rgb[i], expected[i], 1.0) << u;
  }
  EXPECT_GT(connected, 4);
  EXPECT_EQ(step.columns.stretched(), 0);
}

TEST(InitialColumns, OfAnotherSizeAreResampled) {
  // Three columns and rows to one: the middle one of three is the stored one.
  InitialStep step(smooth_room().room(), 3 * kInitialWidth);
  for (int u = 1; u < 3 * kInitialWidth; u += 33) {
    const auto sources = step.sources(u);
    step.columns.render(u, sources, step.rgb.data());
    const auto expected = mixed_columns(step.view, sources, u / 3);
    for (size_t row = 0; row < kInitialRows; ++row) {
      for (size_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(step.rgb[3 * (3 * row + 1) + c], expected[3 * row + c], 1.5)
            << u << ", row " << row;
      }
    }
  }
}

TEST(InitialColumns, MaskedRowsTakeTheColourOfTheNearestValidOne) {
  constexpr double kMaskedBelow_rad = -0.6;
  SyntheticRoomSpec spec = smooth_spec();
  spec.companion =
      CameraCompanion{.hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
        return std::asin(direction.y()) < kMaskedBelow_rad;
      }};
  const TestRoom room(spec);
  InitialStep step(room.room());
  for (int u = 0; u < kInitialWidth; u += 5) {
    const auto masked = step.columns.render(u, step.sources(u), step.rgb.data());
    ASSERT_EQ(masked.size(), 1U) << u;
    ASSERT_EQ(masked.front().end, kInitialRows);
    const int first = masked.front().begin;
    EXPECT_NEAR(angles_from_pixel({0.0, first - 0.5}, step.view.output).phi_rad, kMaskedBelow_rad,
                0.03);
    for (int row = first; row < kInitialRows; ++row) {
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(step.rgb[static_cast<size_t>(3 * row + c)],
                  step.rgb[static_cast<size_t>(3 * (first - 1) + c)])
            << u << ", row " << row;
      }
    }
  }
  EXPECT_GT(step.columns.stretched(), 0);
}

TEST(InitialColumns, WithoutAValidRowTheWholeColumnIsMasked) {
  SyntheticRoomSpec spec = smooth_spec();
  spec.companion =
      CameraCompanion{.hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
        return direction.x() > 0.0;
      }};
  const TestRoom room(spec);
  InitialStep step(room.room());
  // To the right everything is masked, to the left nothing.
  const auto right = step.columns.render(3 * kInitialWidth / 4, step.sources(3 * kInitialWidth / 4),
                                         step.rgb.data());
  ASSERT_EQ(right.size(), 1U);
  EXPECT_EQ(right.front(), (RowRun{0, kInitialRows}));
  EXPECT_TRUE(
      step.columns.render(kInitialWidth / 4, step.sources(kInitialWidth / 4), step.rgb.data())
          .empty());
}

}  // namespace
}  // namespace raywalk
