#include "core/view/station_positions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/view/test_points.h"
#include "core/view/test_room.h"
#include "core/view/test_steps.h"

namespace raywalk {
namespace {

constexpr PlanPoint kPositionsAt{0.13, -0.08};
constexpr int kPositionsWidth = 512;
constexpr PanoramaSize kPositionsSize{kPositionsWidth, kPositionsWidth / 2};

// What the stations show does not matter here, only where they are.
SyntheticRoomSpec positions_spec() {
  SyntheticRoomSpec spec = smooth_spec();
  spec.width = kPositionsWidth;
  spec.distance_width = kPositionsWidth / 2;
  spec.spacing_m = 0.25;
  return spec;
}
const TestRoom& positions_room() {
  static const TestRoom room(positions_spec());
  return room;
}

// A room in the shape of a sphere around a point beside the viewpoint: its inverse distances are
// smooth.
double sphere_distance_m(const Eigen::Vector3d& direction) {
  constexpr double kRadius_m = 2.2;
  const Eigen::Vector3d from_centre(0.2, -0.3, 0.1);
  const double along = direction.dot(from_centre);
  return -along + std::sqrt(along * along - from_centre.squaredNorm() + kRadius_m * kRadius_m);
}

// The points of a column in that room, with `depth_rows` rows of distances.
class SpherePoints {
 public:
  SpherePoints(int u, int depth_rows)
      : edges_(static_cast<size_t>(depth_rows) + kShiftPadding),
        depth_omega_(omegas(u, depth_rows)),
        omega_(omegas(u, kPositionsSize.height)) {
    points.u = u;
    points.theta_rad = angles_from_pixel({double(u), 0.0}, kPositionsSize).theta_rad;
    points.depth_omega = depth_omega_;
    points.edges = edges_.data();
    points.omega = omega_;
  }
  ColumnPoints points;

 private:
  static std::vector<float> omegas(int u, int rows) {
    const double theta_rad = angles_from_pixel({double(u), 0.0}, kPositionsSize).theta_rad;
    std::vector<float> omega;
    for (int row = 0; row < rows; ++row) {
      const double phi_rad = kHalfPi - (row + 0.5) / rows * kPi;
      omega.push_back(
          static_cast<float>(1.0 / sphere_distance_m(direction_from_angles({theta_rad, phi_rad}))));
    }
    return omega;
  }
  std::vector<std::int32_t> edges_;
  std::vector<float> depth_omega_, omega_;
};

// Where sample `i` lies in the panorama.
PixelPosition position_of(const SamplePositions& at, int i) {
  const PolarPart part(kPositionsSize);
  const RayPlace left = part.place_of(at.offset_left[i]);
  const int right = part.place_of(at.offset_right[i]).column;
  const int apart = (right - left.column + kPositionsWidth) % kPositionsWidth;
  return {left.column + apart * weight_of(at.weight_right[i]) / 32768.0,
          left.row + weight_of(at.weight_lower[i]) / 32768.0};
}

// The largest distance of a column's samples from their exact positions, pixels, where the station
// saw them and the viewpoint sees them within a latitude.
double largest_error_px(PreparedSteps& prepared, int u, int line, int station,
                        double latitude_rad) {
  const RowRun rows{0, kPositionsSize.height};
  const SpherePoints column(u, prepared.view.distances->size().height);
  PositionArrays arrays(kPositionsSize.height);
  const SamplePositions at =
      prepared.steps.positions.find(column.points, line, station, rows, arrays.positions())
          .positions;
  double largest = 0.0;
  for (int row = rows.begin; row < rows.end; ++row) {
    const Eigen::Vector3d direction =
        direction_from_angles(angles_from_pixel({double(u), double(row)}, kPositionsSize));
    const SphereAngles seen = angles_from_direction(
        direction + (prepared.view.viewpoint_m() - station_position(prepared.view, line, station)) /
                        sphere_distance_m(direction));
    const double own_rad = angles_from_direction(direction).phi_rad;
    if (std::max(std::fabs(seen.phi_rad), std::fabs(own_rad)) > latitude_rad) continue;
    const PixelPosition exact = pixel_from_angles(seen, kPositionsSize);
    const PixelPosition found = position_of(at, row - rows.begin);
    const double du = std::remainder(found.u - exact.u, kPositionsWidth) * std::cos(seen.phi_rad);
    const double exact_v = std::clamp(exact.v, 0.0, kPositionsSize.height - 1.0);
    largest = std::max(largest, std::hypot(du, found.v - exact_v));
  }
  return largest;
}

double largest_error_px(PreparedSteps& prepared, double latitude_rad) {
  double largest = 0.0;
  for (int u = 0; u < kPositionsWidth; u += 19) {
    for (int line = 0; line < 4; ++line) {
      for (const int station : {0, 3, 6}) {
        largest = std::max(largest, largest_error_px(prepared, u, line, station, latitude_rad));
      }
    }
  }
  return largest;
}

TEST(StationPositions, AreExactWhereEveryRowIsComputed) {
  SyntheticRoomSpec spec = positions_spec();
  spec.distance_width = spec.width;
  const TestRoom room(spec);
  for (const Arithmetic arithmetic : {Arithmetic::kFloat, Arithmetic::kDouble}) {
    PreparedSteps prepared(room.room(), {.width = kPositionsWidth, .arithmetic = arithmetic},
                           kPositionsAt);
    ASSERT_EQ(prepared.steps.positions.rows_per_distance(), 1);
    EXPECT_LT(largest_error_px(prepared, kHalfPi), 2e-4);
  }
}

TEST(StationPositions, AreWithinAHundredthPixelWhereInterpolatedAwayFromThePoles) {
  const TestRoom& room = positions_room();
  PreparedSteps prepared(room.room(), {.width = kPositionsWidth}, kPositionsAt);
  ASSERT_EQ(prepared.steps.positions.rows_per_distance(), 2);
  EXPECT_LT(largest_error_px(prepared, radians_from_degrees(45.0)), 1e-2);
  // Close to a pole the column of a point turns within a few rows.
  EXPECT_LT(largest_error_px(prepared, kHalfPi), 1.5);
}

TEST(StationPositions, OfARunOfRowsAreThoseOfTheColumn) {
  const TestRoom& room = positions_room();
  for (const int layers : {0, 8}) {
    PreparedSteps prepared(room.room(), {.layers = layers, .width = kPositionsWidth}, kPositionsAt);
    const ColumnPoints& points = prepared.steps.distances.prepare(37);
    PositionArrays all(kPositionsSize.height);
    PositionArrays some(kPositionsSize.height);
    StationPositions& positions = prepared.steps.positions;
    positions.find(points, 0, 2, {0, kPositionsSize.height}, all.positions());
    for (const RowRun rows : {RowRun{0, 1}, RowRun{1, 2}, RowRun{3, 40}, RowRun{64, 127},
                              RowRun{120, kPositionsSize.height}, RowRun{255, 256}}) {
      positions.find(points, 0, 2, rows, some.positions());
      const auto equal = [&](const auto& of_run, const auto& of_column) {
        return std::equal(of_run.begin(), of_run.begin() + (rows.end - rows.begin),
                          of_column.begin() + rows.begin);
      };
      EXPECT_TRUE(equal(some.offset_left, all.offset_left)) << rows.begin << ".." << rows.end;
      EXPECT_TRUE(equal(some.offset_right, all.offset_right)) << rows.begin << ".." << rows.end;
      EXPECT_TRUE(equal(some.weight_right, all.weight_right)) << rows.begin << ".." << rows.end;
      EXPECT_TRUE(equal(some.weight_lower, all.weight_lower)) << rows.begin << ".." << rows.end;
    }
  }
}

TEST(StationPositions, OfThePlainCutAreTheColumnItself) {
  const TestRoom& room = positions_room();
  Renderer renderer(room.room(), {.generation = Generation::kInitial, .width = kPositionsWidth});
  const ViewInputs& view = renderer.prepare(kPositionsAt).inputs();
  StationPositions positions(view);
  PositionArrays arrays(kPositionsSize.height);
  for (const int u : {0, 77, kPositionsWidth - 1}) {
    const StationSamples samples = positions.find_cut(u, 1, 3, arrays.positions());
    EXPECT_EQ(samples.rays, room.room().volume(1).column(3, 0).data());
    for (int row = 0; row < kPositionsSize.height; ++row) {
      const PixelPosition at = position_of(samples.positions, row);
      ASSERT_NEAR(std::remainder(at.u - u, kPositionsWidth), 0.0, 1e-4);
      ASSERT_NEAR(at.v, row, 1e-4);
    }
  }
}

TEST(StationPositions, OffsetsLeadFromStationsAndAcquisitionPointsToTheViewpoint) {
  const TestRoom& room = positions_room();
  PreparedSteps prepared(
      room.room(), {.generation = Generation::kTwoSided, .width = kPositionsWidth}, kPositionsAt);
  for (int u = 0; u < kPositionsWidth; ++u) {
    const double theta_rad = angles_from_pixel({double(u), 0.0}, kPositionsSize).theta_rad;
    for (const RaySource& source : prepared.sources(u)) {
      const ColumnOffset crossing = prepared.steps.positions.acquisition_offset(source, theta_rad);
      ASSERT_NEAR(crossing.forward, -source.d_p_m, 1e-5) << u;
      ASSERT_NEAR(crossing.up, 0.0, 1e-6) << u;
      ASSERT_NEAR(crossing.side, 0.0, 1e-5) << u;
      const ColumnOffset offset =
          prepared.steps.positions.offset_from(source.line, source.station, theta_rad);
      const Eigen::Vector3d station = station_position(prepared.view, source.line, source.station);
      ASSERT_NEAR(std::hypot(offset.forward, offset.up, offset.side),
                  (prepared.view.viewpoint_m() - station).norm(), 1e-6);
    }
  }
}

}  // namespace
}  // namespace raywalk
