// A picture must not depend on the machine: the AVX2 kernels and the generic ones compute the same
// bits.
#include <gtest/gtest.h>

#include <vector>

#include "core/room/polar_part.h"
#include "core/view/column_kernels.h"
#include "core/view/row_table.h"
#include "core/view/test_columns.h"

namespace raywalk {
namespace {

// Odd, so that vector loops have a remainder.
constexpr int kRows = 1021;
constexpr int kRepeats = 40;

class KernelIdentity : public testing::Test {
 protected:
  void SetUp() override {
    if (avx2_ == nullptr) GTEST_SKIP() << "this processor has no AVX2";
  }
  const ColumnKernels* generic_ = column_kernels_named("generic");
  const ColumnKernels* avx2_ = column_kernels_named("avx2");
  RandomColumns random_{21};
  LatitudeTable latitudes_{kRows, kRows};
  ColumnTarget target_{4096, 2048, 4000, 0.375f};
};

TEST_F(KernelIdentity, MixOmega) {
  const auto left = random_.room_omegas(kRows);
  const auto right = random_.room_omegas(kRows);
  std::vector<float> a(left), b(left);
  for (int i = 0; i < kRepeats; ++i) {
    const auto fraction = static_cast<float>(random_.uniform(0.0, 1.0));
    generic_->mix_omega(left.data(), right.data(), fraction, kRows, 0.3f, a.data());
    avx2_->mix_omega(left.data(), right.data(), fraction, kRows, 0.3f, b.data());
    ASSERT_EQ(a, b);
  }
}

TEST_F(KernelIdentity, UpsampleOmega) {
  const auto in = random_.room_omegas(kRows);
  std::vector<int> row;
  std::vector<float> fraction;
  for (int i = 0; i < kRows; ++i) {
    row.push_back(static_cast<int>(random_.uniform(0.0, kRows - 1.0)));
    fraction.push_back(static_cast<float>(random_.uniform(0.0, 1.0)));
  }
  std::vector<float> a(in), b(in);
  generic_->upsample_omega(in.data(), row.data(), fraction.data(), kRows, 0.3f, a.data());
  avx2_->upsample_omega(in.data(), row.data(), fraction.data(), kRows, 0.3f, b.data());
  EXPECT_EQ(a, b);
}

TEST_F(KernelIdentity, SnapToLayers) {
  for (int i = 0; i < kRepeats; ++i) {
    auto a = random_.room_omegas(kRows);
    auto b = a;
    const auto d_p = static_cast<float>(random_.uniform(-1.0, 1.0));
    generic_->snap_to_layers(latitudes_.table(), kRows, {d_p, 0.2f}, {0.08f, 0.11f}, a.data());
    avx2_->snap_to_layers(latitudes_.table(), kRows, {d_p, 0.2f}, {0.08f, 0.11f}, b.data());
    ASSERT_EQ(a, b);
  }
}

TEST_F(KernelIdentity, FindSamples) {
  for (int i = 0; i < kRepeats; ++i) {
    const auto omega = random_.omegas(kRows);
    const ColumnOffset offset = random_.offset(2.0);
    SampleArrays a(kRows), b(kRows);
    generic_->find_samples(latitudes_.table(), omega.data(), kRows, offset, target_, a.positions());
    avx2_->find_samples(latitudes_.table(), omega.data(), kRows, offset, target_, b.positions());
    ASSERT_TRUE(a == b);
  }
}

TEST_F(KernelIdentity, Aim) {
  for (int i = 0; i < kRepeats; ++i) {
    RayLine line;
    for (float& value : line.start) value = static_cast<float>(random_.uniform(-1.0, 1.0));
    for (float& value : line.step) value = static_cast<float>(random_.uniform(-0.01, 0.01));
    SampleArrays a(kRows), b(kRows);
    const ColumnBlock block{{4096, 2048}, 4000, 700};
    generic_->aim(line, kRows, block, a.positions());
    avx2_->aim(line, kRows, block, b.positions());
    ASSERT_TRUE(a == b);
  }
}

TEST_F(KernelIdentity, FindShiftsAndPlaceThem) {
  for (const int per_row : {2, 4, 8}) {
    const auto omega = random_.omegas(kRows);
    const ColumnOffset offset = random_.offset(2.0);
    ShiftArrays found_a(kRows), found_b(kRows);
    const auto found = [](const std::vector<float>& shift) {
      return std::vector<float>(shift.begin(), shift.begin() + kRows);
    };
    generic_->find_shifts(latitudes_.table(), omega.data(), 0, kRows, kRows, offset, target_,
                          found_a.u.data(), found_a.v.data());
    avx2_->find_shifts(latitudes_.table(), omega.data(), 0, kRows, kRows, offset, target_,
                       found_b.u.data(), found_b.v.data());
    ASSERT_EQ(found(found_a.u), found(found_b.u));
    ASSERT_EQ(found(found_a.v), found(found_b.v));
    std::vector<std::int32_t> edges_a(kRows), edges_b(kRows);
    generic_->find_edges(omega.data(), kRows - 1, 0.3f, edges_a.data());
    avx2_->find_edges(omega.data(), kRows - 1, 0.3f, edges_b.data());
    ASSERT_EQ(edges_a, edges_b);
    generic_->add_jumps(found_a.u.data(), found_a.v.data(), kRows - 1, target_, edges_a.data(),
                        found_a.no_between.data());
    avx2_->add_jumps(found_b.u.data(), found_b.v.data(), kRows - 1, target_, edges_a.data(),
                     found_b.no_between.data());
    ASSERT_EQ(found_a.no_between, found_b.no_between);
    const int rows = per_row * kRows;
    SampleArrays a(rows), b(rows);
    const ShiftedRows shifted = found_a.from(0, kRows, per_row);
    ColumnTarget target = target_;
    target.rays = PolarPart({target.width, target.height}).layout();
    generic_->place_shifted(shifted, 0, rows, target, a.positions());
    avx2_->place_shifted(shifted, 0, rows, target, b.positions());
    ASSERT_TRUE(a == b);
  }
}

TEST_F(KernelIdentity, RefineOmega) {
  const ColumnTarget target{128, 64, 100, 0.25f};
  const auto map = random_.room_omegas(128 * 64);
  for (int i = 0; i < kRepeats; ++i) {
    const auto omega = random_.room_omegas(kRows);
    const ColumnOffset offset = random_.offset(0.5);
    std::vector<float> a(kRows), b(kRows);
    generic_->refine_omega(latitudes_.table(), omega.data(), kRows, offset, target, map.data(),
                           0.3f, a.data());
    avx2_->refine_omega(latitudes_.table(), omega.data(), kRows, offset, target, map.data(), 0.3f,
                        b.data());
    ASSERT_EQ(a, b);
  }
}

// Sums and finished columns as the kernels leave them, without the scratch: the fourth value of
// every row, and the byte beyond the column.
std::vector<std::int16_t> without_scratch(std::vector<std::int16_t> sum) {
  for (size_t i = 3; i < sum.size(); i += 4) sum[i] = 0;
  return sum;
}
std::vector<std::uint8_t> without_scratch(std::vector<std::uint8_t> rgb) {
  rgb.pop_back();
  return rgb;
}

class SamplingIdentity : public KernelIdentity {
 protected:
  static constexpr int kColumns = 5;
  static constexpr int kHeight = 64;
  StationSamples first() { return first_samples_.of(rays_.data() + 2); }
  StationSamples second() { return second_samples_.of(rays_.data() + 2); }

  std::vector<std::uint8_t> rays_ = random_.bytes(2 + 3 * kColumns * kHeight);
  SampleArrays first_samples_ = random_.samples(kRows, kColumns, kHeight);
  SampleArrays second_samples_ = random_.samples(kRows, kColumns, kHeight);
  std::vector<std::int16_t> weight_ = random_.weights(kRows);
  std::vector<std::int16_t> sum_a_ = std::vector<std::int16_t>(size_t{4} * kRows), sum_b_ = sum_a_;
  std::vector<std::uint8_t> rgb_a_ = std::vector<std::uint8_t>(size_t{3} * kRows + 1),
                            rgb_b_ = rgb_a_;
};

TEST_F(SamplingIdentity, AccumulatePair) {
  for (const std::int16_t share : {0, 1, 9999, 32767}) {
    generic_->accumulate_pair(first(), second(), share, weight_.data(), kRows, sum_a_.data());
    avx2_->accumulate_pair(first(), second(), share, weight_.data(), kRows, sum_b_.data());
    EXPECT_EQ(without_scratch(sum_a_), without_scratch(sum_b_));
    sum_a_.assign(sum_a_.size(), 0);
    sum_b_ = sum_a_;
  }
}

TEST_F(SamplingIdentity, MixPair) {
  for (const std::int16_t share : {0, 1, 9999, 32767}) {
    generic_->mix_pair(first(), second(), share, kRows, rgb_a_.data());
    avx2_->mix_pair(first(), second(), share, kRows, rgb_b_.data());
    EXPECT_EQ(without_scratch(rgb_a_), without_scratch(rgb_b_));
  }
}

TEST_F(SamplingIdentity, SampleEach) {
  generic_->sample_each(first(), kRows, rgb_a_.data());
  avx2_->sample_each(first(), kRows, rgb_b_.data());
  EXPECT_EQ(without_scratch(rgb_a_), without_scratch(rgb_b_));
}

TEST_F(SamplingIdentity, Finish) {
  for (std::int16_t& value : sum_a_) {
    value = static_cast<std::int16_t>(random_.uniform(-200.0, 64 * 257.0));
  }
  generic_->finish(sum_a_.data(), kRows, rgb_a_.data());
  avx2_->finish(sum_a_.data(), kRows, rgb_b_.data());
  EXPECT_EQ(without_scratch(rgb_a_), without_scratch(rgb_b_));
}

TEST_F(SamplingIdentity, MixWeighted) {
  const auto weight = random_.weights(kRows);
  const auto second_weight = random_.weights(kRows);
  for (const int rows_per_weight : {1, 2, 4, 8}) {
    const std::vector<WeightedPair> pairs = {{first(), second(), 1234, weight.data()},
                                             {second(), first(), 32000, second_weight.data()}};
    std::vector<std::uint8_t> a(3 * kRows + 1), b(3 * kRows + 1);
    generic_->mix_weighted(pairs.data(), 2, 5, kRows, rows_per_weight, a.data());
    avx2_->mix_weighted(pairs.data(), 2, 5, kRows, rows_per_weight, b.data());
    a.back() = b.back() = 0;
    EXPECT_EQ(a, b);
  }
}

TEST_F(KernelIdentity, WeighRows) {
  const auto visible = random_.bytes(size_t{3} * kRows);
  const std::vector<const std::uint8_t*> seen = {visible.data(), visible.data() + kRows,
                                                 visible.data() + 2 * kRows};
  const std::vector<float> shares = {1.0f, 0.25f, 1e-3f};
  struct Weighed {
    std::vector<std::int16_t> weights[3];
    std::vector<std::uint8_t> most = std::vector<std::uint8_t>(kRows), seeing = most;
    bool operator==(const Weighed&) const = default;
  };
  const auto weighed = [&](const ColumnKernels& kernels) {
    Weighed result;
    std::vector<float> scale(kRows);
    std::vector<std::int16_t*> weights;
    for (auto& of_line : result.weights) {
      of_line.resize(kRows);
      weights.push_back(of_line.data());
    }
    kernels.weigh_rows(seen.data(), shares.data(), 3, kRows, weights.data(), result.most.data(),
                       result.seeing.data(), scale.data());
    return result;
  };
  EXPECT_TRUE(weighed(*generic_) == weighed(*avx2_));
}

TEST_F(KernelIdentity, MixColumns) {
  std::vector<std::vector<std::uint8_t>> columns(4);
  for (auto& column : columns) column = random_.bytes(kRows);
  const std::uint8_t* in[4] = {columns[0].data(), columns[1].data(), columns[2].data(),
                               columns[3].data()};
  const std::vector<std::vector<std::int16_t>> weights = {
      {0, 32767}, {20000, 12767}, {9000, 8000, 7767, 8000}};
  for (const auto& weight : weights) {
    std::vector<std::uint8_t> a(kRows), b(kRows);
    const int count = static_cast<int>(weight.size());
    generic_->mix_columns(in, weight.data(), count, kRows, a.data());
    avx2_->mix_columns(in, weight.data(), count, kRows, b.data());
    EXPECT_EQ(a, b);
  }
}

TEST_F(KernelIdentity, WriteRows) {
  constexpr int kCount = 27;
  constexpr size_t kColumnBytes = size_t{3} * kRows;
  const auto columns = random_.bytes(kColumnBytes * kCount + 4);
  std::vector<std::uint8_t> a(kColumnBytes * kCount), b(a);
  generic_->write_rows(columns.data(), kColumnBytes, kCount, kRows, a.data(), 3 * kCount);
  avx2_->write_rows(columns.data(), kColumnBytes, kCount, kRows, b.data(), 3 * kCount);
  EXPECT_EQ(a, b);
}

TEST_F(KernelIdentity, ProjectPoints) {
  for (int i = 0; i < kRepeats; ++i) {
    const auto omega = random_.omegas(kRows);
    const ColumnOffset offset = random_.offset(2.0);
    const float radius = i % 3 == 0 ? 0.0f : static_cast<float>(random_.uniform(-0.1, 0.1));
    PointArrays a(kRows), b(kRows);
    generic_->project_points(latitudes_.table(), omega.data(), kRows, offset, radius, target_,
                             a.points());
    avx2_->project_points(latitudes_.table(), omega.data(), kRows, offset, radius, target_,
                          b.points());
    ASSERT_TRUE(a == b);
  }
}

TEST_F(KernelIdentity, ProjectRing) {
  const LatitudeTable ring(kRows, 2 * kRows);
  for (int i = 0; i < kRepeats; ++i) {
    const auto omega = random_.omegas(2 * kRows);
    const auto d_p = static_cast<float>(random_.uniform(-1.0, 1.0));
    std::vector<float> position_a(size_t{2} * kRows), position_b(size_t{2} * kRows),
        omega_a(position_a), omega_b(position_a);
    generic_->project_ring(ring.table(), omega.data(), 2 * kRows, 2 * kRows, {d_p, 0.2f},
                           position_a.data(), omega_a.data());
    avx2_->project_ring(ring.table(), omega.data(), 2 * kRows, 2 * kRows, {d_p, 0.2f},
                        position_b.data(), omega_b.data());
    ASSERT_EQ(position_a, position_b);
    ASSERT_EQ(omega_a, omega_b);
  }
}

TEST(ColumnKernels, GenericSetExistsAndUnknownSetsDoNot) {
  ASSERT_NE(column_kernels_named("generic"), nullptr);
  EXPECT_STREQ(column_kernels_named("generic")->name, "generic");
  EXPECT_EQ(column_kernels_named("avx1024"), nullptr);
}

}  // namespace
}  // namespace raywalk
