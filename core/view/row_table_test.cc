#include "core/view/row_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

TEST(ColumnOffset, IsTheDisplacementAlongTheColumnsOwnAxes) {
  const Eigen::Vector3d displacement(0.3, -0.2, 0.7);
  for (const double theta_deg : {-170.0, -45.0, 0.0, 30.0, 90.0}) {
    const double theta = radians_from_degrees(theta_deg);
    const ColumnOffset offset = column_offset(displacement, theta);
    EXPECT_NEAR(offset.forward, displacement.dot(direction_from_angles({theta, 0.0})), 1e-7);
    EXPECT_NEAR(offset.up, displacement.dot(direction_from_angles({0.0, kHalfPi})), 1e-7);
    EXPECT_NEAR(offset.side, displacement.dot(direction_from_angles({theta + kHalfPi, 0.0})), 1e-7);
  }
}

TEST(LatitudeTable, HoldsTheRowsOfAPanoramaAndTheOppositeColumnUpwards) {
  constexpr PanoramaSize kSize{64, 32};
  const LatitudeTable table(kSize.height, 2 * kSize.height);
  for (int row = 0; row < kSize.height; ++row) {
    const double phi = angles_from_pixel({0.0, double(row)}, kSize).phi_rad;
    EXPECT_NEAR(table.table().sin_phi[row], std::sin(phi), 1e-7);
    EXPECT_NEAR(table.table().cos_phi[row], std::cos(phi), 1e-7);
    // Up the opposite column: the same latitude, looking backward.
    const int opposite = 2 * kSize.height - 1 - row;
    EXPECT_NEAR(table.table().sin_phi[opposite], std::sin(phi), 1e-7);
    EXPECT_NEAR(table.table().cos_phi[opposite], -std::cos(phi), 1e-7);
  }
  EXPECT_EQ(table.table(5).sin_phi[0], table.table().sin_phi[5]);
}

}  // namespace
}  // namespace raywalk
