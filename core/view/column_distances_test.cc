#include "core/view/column_distances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/view/test_points.h"
#include "core/view/test_room.h"
#include "core/view/test_steps.h"

namespace raywalk {
namespace {

constexpr PlanPoint kDistancesAt{-0.12, -0.1};

TEST(ColumnDistances, EqualTheViewsAtItsOwnColumns) {
  SyntheticRoomSpec spec = pillar_spec();
  spec.width = 192;
  spec.distance_width = 64;  // every third column and row coincides
  const TestRoom room(spec);
  PreparedSteps prepared(room.room(), {.width = spec.width}, kDistancesAt);
  const DistanceView& view = *prepared.view.distances;
  for (int theta = 0; theta < spec.distance_width; ++theta) {
    const ColumnPoints& points = prepared.steps.distances.prepare(3 * theta + 1);
    ASSERT_EQ(points.depth_theta, theta);
    for (size_t row = 0; row < points.depth_omega.size(); ++row) {
      ASSERT_EQ(points.depth_omega[row], view.column(theta)[row]) << theta << ", " << row;
      ASSERT_EQ(points.omega[3 * row + 1], points.depth_omega[row]) << theta << ", " << row;
    }
  }
}

TEST(ColumnDistances, AreInterpolatedOnOneSurfaceAndNearestAcrossAnEdge) {
  const TestRoom& room = pillar_room();
  PreparedSteps prepared(room.room(), {.width = 256}, kDistancesAt);
  const DistanceView& view = *prepared.view.distances;
  int across = 0;
  for (int u = 0; u < 256; ++u) {
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    // Output columns lie a quarter of a column of the distances to either side of its own.
    const bool left_of_own = u % 2 == 0;
    const int own = u / 2;
    const int other = (own + (left_of_own ? 127 : 1)) % 128;
    EXPECT_EQ(points.depth_theta, own);
    for (size_t row = 0; row < points.depth_omega.size(); ++row) {
      const float a = view.column(own)[row];
      const float b = view.column(other)[row];
      if (std::fabs(a - b) <= view.surface_tolerance() * std::max(a, b)) {
        ASSERT_NEAR(points.depth_omega[row], 0.75 * a + 0.25 * b, 1e-6) << u << ", " << row;
      } else {
        ASSERT_EQ(points.depth_omega[row], a) << u << ", " << row;
        ++across;
      }
    }
  }
  EXPECT_GT(across, 20);
}

TEST(ColumnDistances, AreThoseOfTheRoomAwayFromEdges) {
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), {.width = 256}, kDistancesAt);
  const PanoramaSize size = prepared.view.output;
  for (int u = 0; u < size.width; u += 5) {
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    EXPECT_NEAR(points.theta_rad, angles_from_pixel({double(u), 0.0}, size).theta_rad, 1e-12);
    for (size_t row = 0; row < points.depth_omega.size(); ++row) {
      const Eigen::Vector3d from = prepared.view.viewpoint_m();
      const Eigen::Vector3d point = point_at(
          room.spec().scene, from, {double(u), 2.0 * static_cast<double>(row) + 0.5}, size);
      ASSERT_NEAR(points.depth_omega[row] * (point - from).norm(), 1.0, 0.05) << u << ", " << row;
    }
  }
}

TEST(ColumnDistances, MarkTheEdgesBetweenRows) {
  const TestRoom& room = pillar_room();
  PreparedSteps prepared(room.room(), {.width = 256}, kDistancesAt);
  int edges = 0;
  for (int u = 0; u < 256; ++u) {
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    for (size_t row = 0; row + 1 < points.depth_omega.size(); ++row) {
      const float a = points.depth_omega[row];
      const float b = points.depth_omega[row + 1];
      const bool edge =
          std::fabs(a - b) > prepared.view.distances->surface_tolerance() * std::max(a, b);
      ASSERT_EQ(points.edges[row], edge ? -1 : 0) << u << ", " << row;
      edges += edge ? 1 : 0;
    }
  }
  EXPECT_GT(edges, 10);
}

// The layers are those around a point of the line, however high the viewpoint is above it.
void expect_points_on_layers(double above_m) {
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), {.layers = 6, .width = 256}, {kDistancesAt, above_m});
  const LayerSpacing layers = prepared.view.layers.value();
  for (int u = 0; u < 256; u += 7) {
    const ColumnPoints exact = prepared.steps.distances.prepare(u);
    const RaySource source = prepared.sources(u).front();
    const double d_p_m = source.d_p_m;
    const ColumnPoints snapped = prepared.steps.distances.in_layers(exact, source);
    for (int row = 0; row < 128; ++row) {
      const double phi = angles_from_pixel({double(u), double(row)}, {256, 128}).phi_rad;
      const auto i = static_cast<size_t>(row);
      const auto from_line = [&](double omega) {
        return 1.0 / std::hypot(std::cos(phi) / omega - d_p_m, std::sin(phi) / omega + above_m);
      };
      const double layer = (from_line(snapped.omega[i]) - layers.omega_min) / layers.step - 0.5;
      ASSERT_NEAR(layer, std::round(layer), 0.01) << u << ", " << row;
      // The nearest one, so that points move by at most half a layer.
      ASSERT_LE(std::fabs(from_line(snapped.omega[i]) - from_line(exact.omega[i])),
                0.51 * layers.step)
          << u << ", " << row;
    }
  }
}

TEST(ColumnDistances, PointsInLayersLieOnLayers) {
  for (const double above_m : {0.0, 0.25, -0.25}) expect_points_on_layers(above_m);
}

TEST(ColumnDistances, WithoutLayersPointsStayWhereTheyAre) {
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), {.width = 256, .arithmetic = Arithmetic::kDouble},
                         kDistancesAt);
  const ColumnPoints& points = prepared.steps.distances.prepare(40);
  const ColumnPoints same = prepared.steps.distances.in_layers(points, {.d_p_m = 0.4});
  EXPECT_EQ(same.omega.data(), points.omega.data());
  EXPECT_EQ(same.omega.size(), 128U);
}

}  // namespace
}  // namespace raywalk
