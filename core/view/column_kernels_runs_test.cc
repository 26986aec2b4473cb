// Kernels for runs of rows: their positions, and rows that need no work.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/view/column_kernels.h"
#include "core/view/row_table.h"
#include "core/view/test_columns.h"

namespace raywalk {
namespace {

class KernelRuns : public Kernels {};
INSTANTIATE_TEST_SUITE_P(Sets, KernelRuns, testing::Values("generic", "avx2"), kernel_set_name);

const ColumnTarget kTarget{512, 256, 500, 0.375f};

TEST_P(KernelRuns, ARunIsPlacedAsInTheWholeColumn) {
  constexpr int kDepthRows = 64;
  const LatitudeTable latitudes(kDepthRows, kDepthRows);
  for (const int per_row : {2, 4, 8}) {
    const int rows = kDepthRows * per_row;
    const auto omega = random_.room_omegas(kDepthRows);
    const ColumnOffset offset = random_.offset(1.0);
    ShiftArrays shifts(kDepthRows);
    SampleArrays whole(rows);
    kernels_->find_shifts(latitudes.table(), omega.data(), 0, kDepthRows, kDepthRows, offset,
                          kTarget, shifts.u.data(), shifts.v.data());
    kernels_->place_shifted(shifts.from(0, kDepthRows, per_row), 0, rows, kTarget,
                            whole.positions());
    for (int run = 0; run < 50; ++run) {
      const int begin = static_cast<int>(random_.uniform(0.0, rows));
      const int end = std::min(begin + static_cast<int>(random_.uniform(1.0, rows)), rows);
      // The distances' rows around the run.
      const int first = std::max(begin - per_row / 2, 0) / per_row;
      const int count =
          std::min(std::max(end - 1 - per_row / 2, 0) / per_row + 2, kDepthRows) - first;
      SampleArrays part(end - begin);
      ShiftArrays found(count);
      kernels_->find_shifts(latitudes.table(first), omega.data() + first, first, count, kDepthRows,
                            offset, kTarget, found.u.data(), found.v.data());
      kernels_->place_shifted(found.from(first, kDepthRows, per_row), begin, end, kTarget,
                              part.positions());
      for (int row = begin; row < end; ++row) {
        const auto here = static_cast<size_t>(row - begin);
        const auto there = static_cast<size_t>(row);
        ASSERT_EQ(part.left[here], whole.left[there]) << per_row << " row " << there;
        ASSERT_EQ(part.right[here], whole.right[there]);
        ASSERT_EQ(part.weight_right[here], whole.weight_right[there]);
        ASSERT_EQ(part.weight_lower[here], whole.weight_lower[there]);
      }
    }
  }
}

// Where a point is seen from a station, exactly.
SphereAngles seen_from(double phi_rad, double omega, ColumnOffset offset) {
  return angles_from_direction({omega * offset.side, std::sin(phi_rad) + omega * offset.up,
                                std::cos(phi_rad) + omega * offset.forward});
}

TEST_P(KernelRuns, NearIsWhatTwoStationsSeeLessThanTheLimitApart) {
  constexpr int kRows = 1021;
  const LatitudeTable latitudes(kRows, kRows);
  int near_rows = 0;
  int clear_rows = 0;
  for (int i = 0; i < 40; ++i) {
    const auto omega = random_.room_omegas(kRows);
    const ColumnOffset a = i % 2 == 0 ? ColumnOffset{} : random_.offset(1.0);
    const double apart = random_.uniform(0.01, 0.3);
    const ColumnOffset step = random_.offset(apart);
    const ColumnOffset b{a.forward + step.forward, a.up + step.up, a.side + step.side};
    const double most_theta = random_.uniform(0.001, 0.2);
    const double most_phi = random_.uniform(0.001, 0.2);
    const MoveLimit limit{static_cast<float>(std::tan(most_theta)),
                          static_cast<float>(std::tan(most_phi))};
    std::vector<std::uint8_t> near(kRows, 1);
    near[5] = 0;
    kernels_->keep_near(latitudes.table(), omega.data(), kRows, a, b, limit, near.data());
    EXPECT_EQ(near[5], 0) << "what was not near stays so";
    for (int row = 6; row < kRows; ++row) {
      const auto at = static_cast<size_t>(row);
      const double phi_rad = kHalfPi - (row + 0.5) / kRows * kPi;
      const SphereAngles from_a = seen_from(phi_rad, omega[at], a);
      const SphereAngles from_b = seen_from(phi_rad, omega[at], b);
      const double excess =
          std::max(std::fabs(wrap_angle(from_a.theta_rad - from_b.theta_rad)) / most_theta,
                   std::fabs(from_a.phi_rad - from_b.phi_rad) / most_phi);
      if (std::fabs(excess - 1.0) < 1e-3) continue;  // rounding decides
      ++clear_rows;
      near_rows += near[at];
      ASSERT_EQ(near[at] != 0, excess < 1.0) << i << " row " << row;
    }
  }
  EXPECT_GT(near_rows, clear_rows / 20);
  EXPECT_LT(near_rows, clear_rows - clear_rows / 20);
}

TEST_P(KernelRuns, PointsSeenAcrossAPoleAreNotNear) {
  // 0.8 m behind the viewpoint a point 10 degrees from the zenith 2 m away lies on the other side.
  const LatitudeTable latitudes(18, 18);
  const std::vector<float> omega(18, 0.5f);
  std::vector<std::uint8_t> near(18, 1);
  kernels_->keep_near(latitudes.table(), omega.data(), 18, {}, {-0.8f, 0.0f, 0.0f}, {1.5f, 1.5f},
                      near.data());
  EXPECT_EQ(near[0], 0);
  EXPECT_EQ(near[9], 1);
}

TEST_P(KernelRuns, StoredColumnsAddTheirWeightedMix) {
  const auto first = random_.bytes(300);
  const auto second = random_.bytes(300);
  const auto weight = random_.weights(100);
  std::vector<std::int16_t> sum(400, 123);
  kernels_->accumulate_stored(first.data(), second.data(), 8000, weight.data(), 100, sum.data());
  for (size_t row = 0; row < 100; ++row) {
    for (size_t c = 0; c < 3; ++c) {
      const double mixed =
          first[3 * row + c] + (second[3 * row + c] - first[3 * row + c]) * 8000 / 32768.0;
      ASSERT_NEAR((sum[4 * row + c] - 123) / 64.0, mixed * weight[row] / 32768.0, 1.5 / 64.0);
    }
  }
}

TEST(KernelRunsIdentity, BothSetsComputeTheSame) {
  const ColumnKernels* generic = column_kernels_named("generic");
  const ColumnKernels* avx2 = column_kernels_named("avx2");
  if (avx2 == nullptr) GTEST_SKIP() << "this processor has no AVX2";
  constexpr int kRows = 1021;
  RandomColumns random(6);
  const LatitudeTable latitudes(kRows, kRows);
  for (int i = 0; i < 20; ++i) {
    const auto omega = random.omegas(kRows);
    const ColumnOffset a = random.offset(1.0);
    const ColumnOffset b = random.offset(1.0);
    const auto columns = random.bytes(size_t{6} * kRows);
    const auto weight = random.weights(kRows);
    struct Result {
      std::vector<float> u = std::vector<float>(kRows), v = u;
      std::vector<std::uint8_t> near = std::vector<std::uint8_t>(kRows, 1);
      std::vector<std::int16_t> sum = std::vector<std::int16_t>(size_t{4} * kRows);
      bool operator==(const Result&) const = default;
    };
    const auto result = [&](const ColumnKernels& kernels) {
      Result r;
      kernels.find_shifts(latitudes.table(7), omega.data(), 7, 1000, kRows, a, kTarget, r.u.data(),
                          r.v.data());
      kernels.keep_near(latitudes.table(), omega.data(), kRows, a, b, {0.1f, 0.1f}, r.near.data());
      kernels.accumulate_stored(columns.data(), columns.data() + size_t{3} * kRows, 777,
                                weight.data(), kRows, r.sum.data());
      return r;
    };
    ASSERT_TRUE(result(*generic) == result(*avx2));
  }
}

}  // namespace
}  // namespace raywalk
