// Column kernels that work on inverse distances, against geometry in double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/view/column_kernels.h"
#include "core/view/row_table.h"
#include "core/view/test_columns.h"

namespace raywalk {
namespace {

class KernelDepths : public Kernels {};
INSTANTIATE_TEST_SUITE_P(Sets, KernelDepths, testing::Values("generic", "avx2"), kernel_set_name);

TEST_P(KernelDepths, OmegaIsInterpolatedOnOneSurfaceAndNearestAcrossAnEdge) {
  const std::vector<float> left = {1.0f, 1.0f, 1.0f, 0.0f};
  const std::vector<float> right = {1.1f, 4.0f, 0.5f, 0.0f};
  std::vector<float> out(4);
  kernels_->mix_omega(left.data(), right.data(), 0.25f, 4, 0.2f, out.data());
  EXPECT_FLOAT_EQ(out[0], 1.025f);
  EXPECT_EQ(out[1], 1.0f);
  EXPECT_EQ(out[2], 1.0f);
  EXPECT_EQ(out[3], 0.0f);
  kernels_->mix_omega(left.data(), right.data(), 0.75f, 4, 0.2f, out.data());
  EXPECT_FLOAT_EQ(out[0], 1.075f);
  EXPECT_EQ(out[1], 4.0f);
  EXPECT_EQ(out[2], 0.5f);

  const std::vector<float> in = {2.0f, 2.2f, 9.0f};
  const std::vector<int> row = {0, 1, 1};
  const std::vector<float> fraction = {0.5f, 0.25f, 0.75f};
  kernels_->upsample_omega(in.data(), row.data(), fraction.data(), 3, 0.2f, out.data());
  EXPECT_FLOAT_EQ(out[0], 2.1f);
  EXPECT_EQ(out[1], 2.2f);
  EXPECT_EQ(out[2], 9.0f);
  std::vector<std::int32_t> edge(2);
  kernels_->find_edges(in.data(), 2, 0.2f, edge.data());
  EXPECT_EQ(edge, (std::vector<std::int32_t>{0, -1}));
}

// Inverse distance from the acquisition point of the point at `omega` in direction (c, s).
double omega_from_line(double c, double s, double omega, double d_p, double line_up = 0.0) {
  return omega / std::hypot(c - omega * d_p, s - omega * line_up);
}

TEST_P(KernelDepths, SnappedPointsLieOnTheirNearestLayer) {
  constexpr int kRows = 777;
  const LatitudeTable latitudes(kRows, kRows);
  const RowTable table = latitudes.table();
  int snapped_points = 0;
  for (int i = 0; i < 300; ++i) {
    const auto before = random_.room_omegas(kRows);
    auto after = before;
    const auto d_p = static_cast<float>(i == 0 ? 0.0 : random_.uniform(-2.0, 2.0));
    const auto line_up = static_cast<float>(i % 2 == 0 ? 0.0 : random_.uniform(-1.0, 1.0));
    const double size_m = std::hypot(d_p, line_up);
    const LayerSpacing layers{0.05f, static_cast<float>(random_.uniform(0.01, 1.0))};
    kernels_->snap_to_layers(table, kRows, {d_p, line_up}, layers, after.data());
    for (int row = 0; row < kRows; ++row) {
      const auto at = static_cast<size_t>(row);
      ASSERT_TRUE(std::isfinite(after[at]) && after[at] >= 0.0f);
      if (after[at] == before[at]) continue;
      ++snapped_points;
      const double c = table.cos_phi[row];
      const double s = table.sin_phi[row];
      const double was = omega_from_line(c, s, before[at], d_p, line_up);
      const double is = omega_from_line(c, s, after[at], d_p, line_up);
      const double layer = (is - layers.omega_min) / layers.step - 0.5;
      // How much a rounding of rho moves the layer: rho is of the size of d_p and line_up at least.
      const double rounding = 1e-6 * (1.0 + is * (size_m + 1.0 / after[at])) * is;
      ASSERT_NEAR(layer, std::round(layer), rounding / layers.step + 1e-5);
      if (was >= layers.omega_min) {
        ASSERT_LE(std::fabs(is - was), 0.5 * layers.step * (1.0 + 1e-4) + rounding);
      }
      // A ray meets a layer's circle twice; the point stays on its side of the foot of A.
      const double foot = d_p * c + line_up * s;
      ASSERT_EQ(foot * before[at] > 1.0, foot * after[at] > 1.0 - 1e-5);
    }
  }
  EXPECT_GT(snapped_points, 100000);
}

TEST_P(KernelDepths, SnappedPointsObeyTheLawOfSines) {
  // Equation (5) solved for the source: alpha = phi* + asin((d_p / d_src) sin phi*).
  constexpr int kRows = 200;
  const LatitudeTable latitudes(kRows, kRows);
  const RowTable table = latitudes.table();
  const LayerSpacing layers{0.2f, 0.1f};
  const float d_p = 0.4f;
  std::vector<float> omega(kRows, 0.33f);
  kernels_->snap_to_layers(table, kRows, {d_p, 0.0f}, layers, omega.data());
  for (int row = 0; row < kRows; ++row) {
    const double phi = std::atan2(table.sin_phi[row], table.cos_phi[row]);
    const double rho = 1.0 / omega[static_cast<size_t>(row)];
    const double alpha = std::atan2(rho * std::sin(phi), rho * std::cos(phi) - d_p);
    const double d_src =
        1.0 / omega_from_line(std::cos(phi), std::sin(phi), omega[static_cast<size_t>(row)], d_p);
    EXPECT_NEAR(alpha, phi + std::asin(d_p / d_src * std::sin(phi)), 1e-6);
    const double phi_again = std::atan2(d_src * std::sin(alpha), d_src * std::cos(alpha) + d_p);
    EXPECT_NEAR(phi_again, phi, 1e-12);
  }
}

TEST_P(KernelDepths, RaysThatNeverMeetTheirLayerKeepTheirDistance) {
  // Straight up (phi = 90 degrees) from beside A, the layer's circle of radius 1 / 1.5 around A,
  // 1 m away, is never met.
  const float sin_phi = 1.0f;
  const float cos_phi = 0.0f;
  float omega = 100.0f;
  kernels_->snap_to_layers({&sin_phi, &cos_phi}, 1, {1.0f, 0.0f}, {1.0f, 1.0f}, &omega);
  EXPECT_EQ(omega, 100.0f);
}

TEST_P(KernelDepths, InfinitelyFarSnapsIntoTheFarthestLayer) {
  const float sin_phi = 0.0f;
  const float cos_phi = 1.0f;
  float omega = 0.0f;
  kernels_->snap_to_layers({&sin_phi, &cos_phi}, 1, {0.0f, 0.0f}, {0.0f, 0.5f}, &omega);
  EXPECT_FLOAT_EQ(omega, 0.25f);
}

// A tilted wall, forward + up + side / 2 = 2 m from the viewpoint, and a station's map of it;
// unknown elsewhere.
class WallMap {
 public:
  WallMap() : omega_(static_cast<size_t>(kSize.width) * static_cast<size_t>(kSize.height), -1.0f) {
    const double from_station = 2.0 + kOffset.forward + kOffset.up + 0.5 * kOffset.side;
    for (int u = 0; u < kSize.width; ++u) {
      for (int v = 0; v < kSize.height; ++v) {
        const Eigen::Vector3d d =
            direction_from_angles(angles_from_pixel({double(u), double(v)}, kSize));
        const double towards = d.z() + d.y() + 0.5 * d.x();
        if (towards > 0.05) at(u, v) = static_cast<float>(towards / from_station);
      }
    }
  }
  // Inverse distance from the viewpoint, straight ahead at a latitude.
  static float omega(const RowTable& table, size_t row) {
    return (table.cos_phi[row] + table.sin_phi[row]) / 2.0f;
  }
  float& at(int u, int v) {
    return omega_[static_cast<size_t>(u) * kSize.height + static_cast<size_t>(v)];
  }
  const float* data() const { return omega_.data(); }

  static constexpr PanoramaSize kSize{512, 256};
  static constexpr ColumnOffset kOffset{-0.3f, 0.15f, 0.2f};  // viewpoint - station
  // Straight ahead: theta = 0 lies between two columns.
  static constexpr ColumnTarget kTarget{512, 256, 255, 0.5f};

 private:
  std::vector<float> omega_;
};

// Rows from 55 degrees up to 30 degrees down, where the wall is seen well.
constexpr size_t kWallBegin = 50;
constexpr size_t kWallEnd = 170;

TEST_P(KernelDepths, RefineOmegaMovesAPointOntoTheSurfaceOfTheMap) {
  constexpr int kRows = 256;
  const LatitudeTable latitudes(kRows, kRows);
  const WallMap map;
  // 2 % off, as after a splat to the nearest pixel.
  std::vector<float> omega(kRows), refined(kRows);
  for (size_t row = 0; row < kRows; ++row) {
    omega[row] = WallMap::omega(latitudes.table(), row) * (row % 2 == 0 ? 1.02f : 0.98f);
  }
  kernels_->refine_omega(latitudes.table(), omega.data(), kRows, WallMap::kOffset, WallMap::kTarget,
                         map.data(), 0.1f, refined.data());
  for (size_t row = kWallBegin; row < kWallEnd; ++row) {
    EXPECT_NEAR(refined[row] / WallMap::omega(latitudes.table(), row), 1.0, 0.007) << row;
  }
}

TEST_P(KernelDepths, RefineOmegaKeepsPointsThatTheMapDoesNotHave) {
  constexpr int kRows = 256;
  const LatitudeTable latitudes(kRows, kRows);
  const WallMap map;
  // Nearer than the wall by half; and on the side turned away, where the map knows nothing.
  std::vector<float> nearer(kRows, 0.0f), refined(kRows);
  for (size_t row = kWallBegin; row < kWallEnd; ++row) {
    nearer[row] = 2.0f * WallMap::omega(latitudes.table(), row);
  }
  for (const int ahead : {WallMap::kTarget.u_whole, 0}) {
    kernels_->refine_omega(latitudes.table(), nearer.data(), kRows, WallMap::kOffset,
                           {512, 256, ahead, 0.5f}, map.data(), 0.1f, refined.data());
    EXPECT_EQ(refined, nearer);
  }
}

}  // namespace
}  // namespace raywalk
