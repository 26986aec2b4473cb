// Column kernels that turn directions into pixel positions, against geometry in double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/eye_circle.h"
#include "core/geometry/sphere.h"
#include "core/view/column_kernels.h"
#include "core/view/row_table.h"
#include "core/view/test_columns.h"

namespace raywalk {
namespace {

using Eigen::Vector3d;

constexpr PanoramaSize kPositionsPanorama{4096, 2048};

class KernelPositions : public Kernels {};
INSTANTIATE_TEST_SUITE_P(Sets, KernelPositions, testing::Values("generic", "avx2"),
                         kernel_set_name);

// A direction in a column frame (forward, up, side) from the table's own numbers, so that only the
// kernel's arithmetic is measured.
Vector3d seen_from_station(const RowTable& table, int row, float omega, ColumnOffset o) {
  const double w = omega;
  return {table.cos_phi[row] + w * o.forward, table.sin_phi[row] + w * o.up, w * o.side};
}
SphereAngles angles_of(const Vector3d& seen) {
  return angles_from_direction({seen[2], seen[1], seen[0]});
}

// Distance of a pixel position from its exact direction, in pixels along the equator.
double position_error(PixelPosition found, const Vector3d& seen, const ColumnTarget& target) {
  SphereAngles angles = angles_of(seen);
  const double columns_per_rad = kPositionsPanorama.width / kTwoPi;
  const double u =
      target.u_whole + static_cast<double>(target.u_part) + angles.theta_rad * columns_per_rad;
  const double v = std::clamp(pixel_from_angles(angles, kPositionsPanorama).v, 0.0,
                              kPositionsPanorama.height - 1.0);
  const double du =
      std::remainder(found.u - u, kPositionsPanorama.width) * std::cos(angles.phi_rad);
  return std::hypot(du, found.v - v);
}

// Where the kernel's sums of a point's direction and its offset nearly cancel, the rounding of the
// two to float is magnified by this.
double cancellation(const Vector3d& seen, float omega, ColumnOffset o) {
  const double offset = std::sqrt(double(o.forward) * o.forward + o.up * o.up + o.side * o.side);
  return (1.0 + omega * offset) / seen.norm();
}

PixelPosition position_of(const SampleArrays& samples, size_t row) {
  const int sample = samples.left[row] / 3;
  const int column = sample / kPositionsPanorama.height;
  return {column + weight_of(samples.weight_right[row]) / 32768.0,
          sample % kPositionsPanorama.height + weight_of(samples.weight_lower[row]) / 32768.0};
}

TEST_P(KernelPositions, FindSamplesAgreesWithExactGeometryToAThousandthOfAPixel) {
  const int rows = kPositionsPanorama.height;
  const LatitudeTable latitudes(rows, rows);
  for (int i = 0; i < 200; ++i) {
    const auto omega = i % 2 == 0 ? random_.omegas(rows) : random_.room_omegas(rows);
    const ColumnOffset offset = random_.offset(i < 100 ? 0.7 : 1e-3);
    const ColumnTarget target{kPositionsPanorama.width, kPositionsPanorama.height,
                              static_cast<int>(random_.uniform(0.0, kPositionsPanorama.width)),
                              static_cast<float>(random_.uniform(0.0, 0.999))};
    SampleArrays samples(rows);
    kernels_->find_samples(latitudes.table(), omega.data(), rows, offset, target,
                           samples.positions());
    for (int row = 0; row < rows; ++row) {
      const auto at = static_cast<size_t>(row);
      ASSERT_EQ(samples.left[at] % 3, 0);
      // The right sample is one column on, around the back.
      const int left = samples.left[at] / 3;
      const int right = samples.right[at] / 3;
      ASSERT_EQ((left / kPositionsPanorama.height + 1) % kPositionsPanorama.width,
                right / kPositionsPanorama.height);
      ASSERT_EQ(left % kPositionsPanorama.height, right % kPositionsPanorama.height);
      ASSERT_LE(left % kPositionsPanorama.height, kPositionsPanorama.height - 2)
          << "there is a row below";

      const Vector3d seen = seen_from_station(latitudes.table(), row, omega[at], offset);
      const double magnified = cancellation(seen, omega[at], offset);
      ASSERT_LT(position_error(position_of(samples, at), seen, target),
                1e-3 * std::max(1.0, magnified / 4.0))
          << "row " << row << " omega " << omega[at];
    }
  }
}

TEST_P(KernelPositions, StationAtTheViewpointIsReadInTheViewsDirection) {
  const int rows = kPositionsPanorama.height;
  const LatitudeTable latitudes(rows, rows);
  for (const float omega : {0.0f, 1.0f, 1e6f}) {
    const std::vector<float> omegas(static_cast<size_t>(rows), omega);
    SampleArrays samples(rows);
    kernels_->find_samples(latitudes.table(), omegas.data(), rows, {}, {4096, 2048, 17, 0.0f},
                           samples.positions());
    for (int row = 0; row < rows; ++row) {
      const PixelPosition found = position_of(samples, static_cast<size_t>(row));
      ASSERT_EQ(found.u, 17.0);
      ASSERT_NEAR(found.v, row, 1e-3);
    }
  }
}

TEST_P(KernelPositions, AimFindsDirectionsInTheColumnsOfABlock) {
  constexpr int kCount = 300;
  for (int i = 0; i < 200; ++i) {
    RayLine line;
    for (float& value : line.start) value = static_cast<float>(random_.uniform(-1.0, 1.0));
    for (float& value : line.step) value = static_cast<float>(random_.uniform(-0.01, 0.01));
    const bool whole = i % 2 == 0;
    const int first = static_cast<int>(random_.uniform(0.0, kPositionsPanorama.width));
    const ColumnBlock block{kPositionsPanorama, first, whole ? kPositionsPanorama.width : 100};
    SampleArrays samples(kCount);
    kernels_->aim(line, kCount, block, samples.positions());
    for (int n = 0; n < kCount; ++n) {
      const auto at = static_cast<size_t>(n);
      const int left = samples.left[at] / 3 / kPositionsPanorama.height;
      const int right = samples.right[at] / 3 / kPositionsPanorama.height;
      ASSERT_GE(samples.left[at], 0);
      ASSERT_GE(samples.right[at], 0);
      // Two rows are read, and never beyond the block.
      ASSERT_LE(samples.left[at], (block.columns * kPositionsPanorama.height - 2) * 3);
      ASSERT_LE(samples.right[at], (block.columns * kPositionsPanorama.height - 2) * 3);
      const Vector3d direction(line.start[0] + double(n) * line.step[0],
                               line.start[1] + double(n) * line.step[1],
                               line.start[2] + double(n) * line.step[2]);
      const PixelPosition exact =
          pixel_from_angles(angles_from_direction(direction), kPositionsPanorama);
      PixelPosition found = position_of(samples, at);
      found.u += first;
      const double v = std::clamp(exact.v, 0.0, kPositionsPanorama.height - 1.0);
      const double plan = std::hypot(direction.x(), direction.z()) / direction.norm();
      const double du = std::remainder(found.u - exact.u, kPositionsPanorama.width);
      const double within =
          std::fmod(exact.u - first + 2.0 * kPositionsPanorama.width, kPositionsPanorama.width);
      if (within >= block.columns - 1) continue;  // outside the block
      if (!whole) {
        ASSERT_EQ(right, left + 1);
      }
      ASSERT_LT(std::hypot(du * plan, found.v - v), 2e-3) << direction.transpose();
    }
  }
}

TEST_P(KernelPositions, FindShiftsAgreesWithExactGeometry) {
  constexpr int kRows = 512;
  const LatitudeTable latitudes(kRows, kRows);
  for (int i = 0; i < 100; ++i) {
    const auto omega = random_.room_omegas(kRows);
    const ColumnOffset offset = random_.offset(0.7);
    const ColumnTarget target{kPositionsPanorama.width, kPositionsPanorama.height, 0, 0.0f};
    std::vector<float> shift_u(kRows), shift_v(kRows);
    kernels_->find_shifts(latitudes.table(), omega.data(), 0, kRows, kRows, offset, target,
                          shift_u.data(), shift_v.data());
    for (int row = 0; row < kRows; ++row) {
      const auto at = static_cast<size_t>(row);
      const double own_v = (row + 0.5) * kPositionsPanorama.height / kRows - 0.5;
      const double v = std::clamp(own_v + shift_v[at], 0.0, kPositionsPanorama.height - 1.0);
      const Vector3d seen = seen_from_station(latitudes.table(), row, omega[at], offset);
      const double magnified = cancellation(seen, omega[at], offset);
      ASSERT_LT(position_error({shift_u[at], v}, seen, target),
                1e-3 * std::max(1.0, magnified / 4.0));
    }
  }
}

constexpr ColumnTarget kShiftTarget{kPositionsPanorama.width, kPositionsPanorama.height, 100,
                                    0.25f};

// Positions of `per_row` output rows for every row; as many output rows as the panorama has.
std::vector<PixelPosition> placed(const ColumnKernels& kernels, const ShiftArrays& shifts, int rows,
                                  int per_row) {
  SampleArrays samples(rows * per_row);
  kernels.place_shifted(shifts.from(0, rows, per_row), 0, rows * per_row, kShiftTarget,
                        samples.positions());
  std::vector<PixelPosition> positions;
  for (int i = 0; i < rows * per_row; ++i) {
    positions.push_back(position_of(samples, static_cast<size_t>(i)));
  }
  return positions;
}

TEST_P(KernelPositions, PlaceShiftedInterpolatesShiftsBetweenRows) {
  for (const int per_row : {2, 4, 8}) {
    const int rows = kPositionsPanorama.height / per_row;
    ShiftArrays shifts(rows);
    for (size_t i = 0; i < static_cast<size_t>(rows); ++i) {
      shifts.u[i] = static_cast<float>(random_.uniform(-50.0, 50.0));
      shifts.v[i] = static_cast<float>(random_.uniform(-5.0, 5.0));
      shifts.no_between[i] = random_.uniform(0.0, 1.0) < 0.3 ? -1 : 0;
    }
    const auto positions = placed(*kernels_, shifts, rows, per_row);
    for (int i = 0; i < rows * per_row; ++i) {
      // The output row lies between the centres of these two.
      const int between = i - per_row / 2;
      const auto row = static_cast<size_t>(std::max(0, between / per_row));
      const auto next = std::min(between < 0 ? row : row + 1, static_cast<size_t>(rows) - 1);
      // Across an edge the nearer one's.
      const double linear = next == row ? 0.0 : (between % per_row + 0.5) / per_row;
      const double f = shifts.no_between[row] == 0 ? linear : std::round(linear);
      const double du = shifts.u[row] + f * (shifts.u[next] - shifts.u[row]);
      const double dv = shifts.v[row] + f * (shifts.v[next] - shifts.v[row]);
      const PixelPosition found = positions[static_cast<size_t>(i)];
      ASSERT_NEAR(found.u, 100.25 + du, 1e-3) << per_row << ' ' << i;
      ASSERT_NEAR(found.v, std::clamp(i + dv, 0.0, kPositionsPanorama.height - 1.0), 1e-3) << i;
    }
  }
}

TEST_P(KernelPositions, PlaceShiftedDoesNotInterpolateOverAPole) {
  // Beyond the pole a point appears half a turn away; nothing lies in between.
  constexpr int kPerRow = 4;
  constexpr int kRows = kPositionsPanorama.height / kPerRow;
  ShiftArrays shifts(kRows);
  std::fill_n(shifts.u.begin(), kRows, 10.0f);
  std::fill_n(shifts.u.begin(), 5, 10.0f - 2048.0f);
  std::fill_n(shifts.v.begin(), kRows, 0.0f);
  const std::vector<std::int32_t> edges(kRows);
  kernels_->add_jumps(shifts.u.data(), shifts.v.data(), kRows - 1, kShiftTarget, edges.data(),
                      shifts.no_between.data());
  for (const PixelPosition& found : placed(*kernels_, shifts, kRows, kPerRow)) {
    const bool turned = std::fabs(found.u - (110.25 + 2048.0)) < 1e-3;
    ASSERT_TRUE(turned || std::fabs(found.u - 110.25) < 1e-3) << found.u;
  }
}

TEST_P(KernelPositions, ProjectPointsAgreesWithExactGeometry) {
  const int rows = 512;
  const LatitudeTable latitudes(rows, rows);
  const ColumnTarget target{kPositionsPanorama.width, kPositionsPanorama.height, 0, 0.0f};
  for (int i = 0; i < 100; ++i) {
    const auto omega = random_.room_omegas(rows);
    const ColumnOffset offset = random_.offset(0.5);
    PointArrays found(rows);
    kernels_->project_points(latitudes.table(), omega.data(), rows, offset, 0.0f, target,
                             found.points());
    for (int row = 0; row < rows; ++row) {
      const auto at = static_cast<size_t>(row);
      const Vector3d seen = seen_from_station(latitudes.table(), row, omega[at], offset);
      const double magnified = cancellation(seen, omega[at], offset);
      ASSERT_NEAR(found.omega[at] * seen.norm() / omega[at], 1.0, 1e-6 * magnified);
      ASSERT_LT(
          position_error({found.u[at], std::clamp(double(found.v[at]), 0.0, 2047.0)}, seen, target),
          1e-3 * std::max(1.0, magnified / 4.0));
      // The pixels it covers include the one it lies in.
      ASSERT_LE(found.first_row[at], std::lround(found.v[at]));
      ASSERT_GE(found.last_row[at], std::lround(found.v[at]));
      ASSERT_LE(found.first_column[at], std::lround(found.u[at]));
      ASSERT_GE(found.last_column[at], std::lround(found.u[at]));
      ASSERT_GE(found.first_column[at], -target.width);
      ASSERT_LT(found.last_column[at], 2 * target.width);
    }
  }
}

TEST_P(KernelPositions, ProjectPointsToACircleAgreesWithTheEyesOfTheirColumns) {
  const int rows = 512;
  const LatitudeTable latitudes(rows, rows);
  const ColumnTarget target{kPositionsPanorama.width, kPositionsPanorama.height, 300, 0.25f};
  int inside = 0;
  for (int i = 0; i < 100; ++i) {
    const auto omega = random_.room_omegas(rows);
    const ColumnOffset offset = random_.offset(0.5);
    const EyeCircle eye{{0, 0, 0}, random_.uniform(-0.1, 0.1)};
    PointArrays found(rows);
    kernels_->project_points(latitudes.table(), omega.data(), rows, offset,
                             static_cast<float>(eye.radius_m), target, found.points());
    for (int row = 0; row < rows; ++row) {
      const auto at = static_cast<size_t>(row);
      // In the column's frame.
      const Vector3d point =
          seen_from_station(latitudes.table(), row, omega[at], offset) / omega[at];
      const auto seen = eye.direction_of({point.z(), point.y(), point.x()});
      if (!seen) {
        ASSERT_EQ(found.omega[at], -1.0f);
        ++inside;
        continue;
      }
      const double ahead_m =
          std::sqrt(point.x() * point.x() + point.z() * point.z() - eye.radius_m * eye.radius_m);
      if (ahead_m < 0.02) continue;  // what touches the circle is seen in many directions
      const double distance_m = std::hypot(ahead_m, point.y());
      const double u = 300.25 + seen->theta_rad * target.width / kTwoPi;
      const double v = (kHalfPi - seen->phi_rad) * target.height / kPi - 0.5;
      const double columns = std::remainder(found.u[at] - u, target.width) * ahead_m / distance_m;
      ASSERT_NEAR(columns, 0.0, 4e-3 / distance_m + 1e-3);
      ASSERT_NEAR(found.v[at], v, 4e-3 / distance_m + 1e-3);
      ASSERT_GE(found.first_column[at], -target.width);
      ASSERT_LT(found.last_column[at], 2 * target.width);
      if (found.omega[at] < 0.0f) continue;  // covers no pixel
      ASSERT_NEAR(found.omega[at] * distance_m, 1.0, 1e-4);
    }
  }
  EXPECT_GT(inside, 20);
}

TEST_P(KernelPositions, MarkedPixelsAreTheFirstTwoColumnsAndRowsThatAPointCovers) {
  const int rows = 512;
  const LatitudeTable latitudes(rows, rows);
  const ColumnTarget target{1024, 512, 1000, 0.25f};
  int empty = 0;
  int wide = 0;
  for (int i = 0; i < 100; ++i) {
    auto omega = random_.room_omegas(rows);
    omega[7] = -1.0f;  // unknown
    PointArrays found(rows);
    kernels_->project_points(latitudes.table(), omega.data(), rows, random_.offset(0.5), 0.0f,
                             target, found.points());
    for (size_t at = 0; at < omega.size(); ++at) {
      const int upper = std::max(found.first_row[at], 0);
      const int lower = std::min(found.last_row[at], target.height - 1);
      const int columns = found.last_column[at] - found.first_column[at] + 1;
      if (at == 7 || columns < 1 || lower < upper) {
        ASSERT_EQ(found.omega[at], -1.0f) << "nothing is marked";
        ASSERT_EQ(found.is_wide[at], 0);
        ++empty;
        continue;
      }
      const auto pixel = [&](int column) {
        return wrapped_column(column, target.width) * target.height + upper;
      };
      ASSERT_EQ(found.left[at], pixel(found.first_column[at]));
      ASSERT_EQ(found.right[at], pixel(found.first_column[at] + (columns > 1 ? 1 : 0)));
      ASSERT_EQ(found.down[at], lower > upper ? 1 : 0);
      ASSERT_EQ(found.is_wide[at], columns > 2 || lower - upper > 1 ? 1 : 0);
      wide += found.is_wide[at];
    }
  }
  EXPECT_GT(empty, 100);
  EXPECT_GT(wide, 100);
}

TEST_P(KernelPositions, ProjectRingAgreesWithExactGeometryAllAround) {
  constexpr int kRows = 512;
  const LatitudeTable ring(kRows, 2 * kRows);
  for (int i = 0; i < 100; ++i) {
    const auto omega = random_.room_omegas(2 * kRows);
    const auto d_p = static_cast<float>(random_.uniform(-0.7, 0.7));
    const auto line_up = i % 2 == 0 ? 0.0f : static_cast<float>(random_.uniform(-0.7, 0.7));
    std::vector<float> position(size_t{2} * kRows), from_line(size_t{2} * kRows);
    kernels_->project_ring(ring.table(), omega.data(), 2 * kRows, 2 * kRows, {d_p, line_up},
                           position.data(), from_line.data());
    for (int row = 0; row < 2 * kRows; ++row) {
      const auto at = static_cast<size_t>(row);
      const double forward = ring.table().cos_phi[row] - double(omega[at]) * d_p;
      const double up = ring.table().sin_phi[row] - double(omega[at]) * line_up;
      const double length = std::hypot(forward, up);
      const double magnified = (1.0 + omega[at] * std::hypot(d_p, line_up)) / length;
      ASSERT_GE(position[at], -0.5f);
      ASSERT_LT(position[at], 2 * kRows - 0.5f + 1e-3f);
      const double exact = (kHalfPi - std::atan2(up, forward)) * kRows / kPi - 0.5;
      ASSERT_NEAR(std::remainder(position[at] - exact, 2.0 * kRows), 0.0, 2e-4 * magnified);
      ASSERT_NEAR(from_line[at] * length / omega[at], 1.0, 1e-6 * magnified);
    }
  }
}

}  // namespace
}  // namespace raywalk
