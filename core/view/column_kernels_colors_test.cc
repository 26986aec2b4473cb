// Column kernels that read, mix and write colours, against exact arithmetic.
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

class KernelColors : public Kernels {};
INSTANTIATE_TEST_SUITE_P(Sets, KernelColors, testing::Values("generic", "avx2"), kernel_set_name);

// Random samples of two stations within small rays, and what a sample of them is exactly.
class KernelSampling : public Kernels {
 protected:
  static constexpr int kColumns = 6;
  static constexpr int kHeight = 50;
  static constexpr int kRows = 999;
  const std::uint8_t* rays() const { return padded_.data() + 2; }
  StationSamples first() { return first_.of(rays()); }
  StationSamples second() { return second_.of(rays()); }

  double exact(const SampleArrays& samples, size_t row, size_t c) const {
    const double fu = weight_of(samples.weight_right[row]) / 32768.0;
    // Down the column samples are interpolated in 1/128.
    const double fv = std::round(weight_of(samples.weight_lower[row]) / 256.0) / 128.0;
    const std::uint8_t* left = rays() + samples.left[row] + c;
    const std::uint8_t* right = rays() + samples.right[row] + c;
    const double upper = left[0] + fu * (right[0] - left[0]);
    const double lower = left[3] + fu * (right[3] - left[3]);
    return upper + fv * (lower - upper);
  }
  double exact_mix(double share, size_t row, size_t c) const {
    return exact(first_, row, c) + share * (exact(second_, row, c) - exact(first_, row, c));
  }

  std::vector<std::uint8_t> padded_ = random_.bytes(2 + 3 * kColumns * kHeight);
  SampleArrays first_ = random_.samples(kRows, kColumns, kHeight);
  SampleArrays second_ = random_.samples(kRows, kColumns, kHeight);
  std::vector<std::int16_t> weight_ = random_.weights(kRows);
};

INSTANTIATE_TEST_SUITE_P(Sets, KernelSampling, testing::Values("generic", "avx2"), kernel_set_name);

// Interpolation across the columns and mixing of two samples round to the nearest 1/128 grey level,
// sums and the weight to 1/64: twice that in total.
TEST_P(KernelSampling, AccumulatePairAddsTheWeightedMixOfTwoStations) {
  for (const std::int16_t share : {0, 1234, 32767}) {
    constexpr std::int16_t kBefore = 1000;
    std::vector<std::int16_t> sum(size_t{4} * kRows, kBefore);
    kernels_->accumulate_pair(first(), second(), share, weight_.data(), kRows, sum.data());
    for (size_t row = 0; row < kRows; ++row) {
      for (size_t c = 0; c < 3; ++c) {
        const double wanted = weight_[row] / 32768.0 * exact_mix(share / 32768.0, row, c);
        ASSERT_NEAR((sum[4 * row + c] - kBefore) / 64.0, wanted, 2.0 / 64.0 + 1e-9) << row;
      }
    }
  }
}

TEST_P(KernelSampling, MixPairIsTheMixOfTwoStationsToTheNearestLevel) {
  for (const std::int16_t share : {0, 1234, 32767}) {
    std::vector<std::uint8_t> rgb(size_t{3} * kRows + 1);
    kernels_->mix_pair(first(), second(), share, kRows, rgb.data());
    for (size_t row = 0; row < kRows; ++row) {
      for (size_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(rgb[3 * row + c], exact_mix(share / 32768.0, row, c), 0.5 + 1.5 / 64.0) << row;
      }
    }
  }
}

TEST_P(KernelSampling, SampleEachIsEachSampleToTheNearestLevel) {
  for (const int count : {kRows, 2, 1}) {  // odd and even
    std::vector<std::uint8_t> rgb(size_t{3} * kRows + 1);
    kernels_->sample_each(first(), count, rgb.data());
    for (size_t row = 0; row < static_cast<size_t>(count); ++row) {
      for (size_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(rgb[3 * row + c], exact(first_, row, c), 0.5 + 1.0 / 64.0) << row;
      }
    }
  }
}

TEST_P(KernelSampling, RowsWithoutWeightAreNotRead) {
  first_.left[0] = first_.right[0] = 2000000000;  // nothing is mapped there
  second_.left[0] = second_.right[0] = 2000000000;
  weight_[0] = 0;
  weight_[1] = 32767;
  std::vector<std::int16_t> sum(size_t{4} * kRows, 77);
  kernels_->accumulate_pair(first(), second(), 5, weight_.data(), 2, sum.data());
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(sum[c], 77);
    EXPECT_NE(sum[4 + c], 77);
  }
}

TEST_P(KernelSampling, MixWeightedIsTheSumOfWeightedPairs) {
  const auto first_weights = random_.weights(kRows);
  std::vector<std::int16_t> second_weights(first_weights);
  for (std::int16_t& weight : second_weights) weight = static_cast<std::int16_t>(32767 - weight);
  second_weights[7] = 0;
  const StationSamples one = first(), other = second();
  for (const int rows_per_weight : {1, 2, 4, 8}) {
    const std::vector<WeightedPair> pairs = {{one, other, 1000, first_weights.data()},
                                             {other, one, 20000, second_weights.data()}};
    std::vector<std::uint8_t> found(3 * kRows + 1);
    kernels_->mix_weighted(pairs.data(), 2, 0, kRows, rows_per_weight, found.data());
    std::vector<std::int16_t> sum(4 * kRows);
    for (const WeightedPair& pair : pairs) {
      std::vector<std::int16_t> weights;
      for (int i = 0; i < kRows; ++i) {
        weights.push_back(pair.weight[static_cast<size_t>(i / rows_per_weight)]);
      }
      kernels_->accumulate_pair(pair.first, pair.second, pair.share, weights.data(), kRows,
                                sum.data());
    }
    std::vector<std::uint8_t> expected(3 * kRows + 1);
    kernels_->finish(sum.data(), kRows, expected.data());
    found.back() = expected.back() = 0;
    EXPECT_EQ(found, expected) << rows_per_weight;
  }
}

TEST_P(KernelColors, WeightsAreInProportionToSharesAndVisibilityAndAddUp) {
  constexpr int kRows = 300;
  auto visible = random_.bytes(size_t{3} * kRows);
  for (size_t row = 0; row < 20; ++row)
    visible[row] = visible[kRows + row] = visible[2 * kRows + row] = 0;
  const std::vector<const std::uint8_t*> seen = {visible.data(), visible.data() + kRows,
                                                 visible.data() + 2 * kRows};
  const std::vector<float> shares = {2.0f, 0.5f, 1e-3f};
  std::vector<std::int16_t> weights(size_t{3} * kRows);
  const std::vector<std::int16_t*> of_line = {weights.data(), weights.data() + kRows,
                                              weights.data() + 2 * kRows};
  std::vector<std::uint8_t> most(kRows), seeing(kRows);
  std::vector<float> scale(kRows);
  kernels_->weigh_rows(seen.data(), shares.data(), 3, kRows, of_line.data(), most.data(),
                       seeing.data(), scale.data());
  for (size_t row = 0; row < kRows; ++row) {
    double total = 0.0;
    int lines = 0;
    for (size_t k = 0; k < 3; ++k) {
      total += double(shares[k]) * seen[k][row];
      lines += seen[k][row] > 0 ? 1 : 0;
    }
    ASSERT_EQ(seeing[row], lines);
    ASSERT_EQ(most[row], std::max({seen[0][row], seen[1][row], seen[2][row]}));
    for (size_t k = 0; k < 3; ++k) {
      const double exact = total > 0.0 ? 32767.0 * shares[k] * seen[k][row] / total : 0.0;
      ASSERT_NEAR(of_line[k][row], exact, 1.01) << row;
    }
  }
}

TEST_P(KernelColors, FinishRoundsToTheNearestLevelAndSaturates) {
  const std::vector<std::int16_t> sum = {
      0, 31, 32, 0, 64 * 200 + 31, 64 * 200 + 32, 64 * 255, 0, 64 * 255 + 63, 20000, -100, 0};
  std::vector<std::uint8_t> rgb(10);
  kernels_->finish(sum.data(), 3, rgb.data());
  rgb.pop_back();  // scratch
  EXPECT_EQ(rgb, (std::vector<std::uint8_t>{0, 0, 1, 200, 201, 255, 255, 255, 0}));
}

TEST_P(KernelColors, MixColumnsIsTheWeightedMean) {
  constexpr int kBytes = 600;
  std::vector<std::vector<std::uint8_t>> columns(4);
  for (auto& column : columns) column = random_.bytes(kBytes);
  const std::uint8_t* in[4] = {columns[0].data(), columns[1].data(), columns[2].data(),
                               columns[3].data()};
  const std::vector<std::vector<std::int16_t>> weights = {{24576, 8191}, {16384, 8192, 4096, 4095}};
  for (const auto& weight : weights) {
    std::vector<std::uint8_t> out(kBytes);
    kernels_->mix_columns(in, weight.data(), static_cast<int>(weight.size()), kBytes, out.data());
    for (size_t i = 0; i < kBytes; ++i) {
      double exact = 0.0;
      for (size_t c = 0; c < weight.size(); ++c) exact += weight[c] / 32768.0 * columns[c][i];
      // Half a level of rounding, a sixteenth for the fixed point.
      ASSERT_NEAR(out[i], exact, 0.5 + 1.0 / 16.0);
    }
  }
}

TEST_P(KernelColors, MixOfEqualColumnsIsTheColumn) {
  std::vector<std::uint8_t> column(256);
  for (size_t i = 0; i < column.size(); ++i) column[i] = static_cast<std::uint8_t>(i);
  const std::uint8_t* in[4] = {column.data(), column.data(), column.data(), column.data()};
  const std::vector<std::vector<std::int16_t>> weights = {
      {32767, 0}, {11111, 21656}, {1, 2, 3, 32761}, {8192, 8192, 8192, 8191}};
  for (const auto& weight : weights) {
    std::vector<std::uint8_t> out(256);
    kernels_->mix_columns(in, weight.data(), static_cast<int>(weight.size()), 256, out.data());
    EXPECT_EQ(out, column);
  }
}

TEST_P(KernelColors, WriteRowsTurnsColumnsIntoRowsOfBgr) {
  constexpr int kRows = 37;
  constexpr size_t kColumnBytes = size_t{3} * kRows + 5;
  for (const int count : {1, 2, 7, 8, 9, 32, 33}) {
    const auto width = static_cast<size_t>(count);
    const auto columns = random_.bytes(kColumnBytes * width + 4);
    const size_t row_bytes = 3 * width + 2;
    std::vector<std::uint8_t> image(row_bytes * kRows, 99);
    kernels_->write_rows(columns.data(), kColumnBytes, count, kRows, image.data(), row_bytes);
    for (size_t row = 0; row < kRows; ++row) {
      const std::uint8_t* out = image.data() + row_bytes * row;
      for (size_t column = 0; column < width; ++column) {
        const std::uint8_t* rgb = columns.data() + kColumnBytes * column + 3 * row;
        for (size_t c = 0; c < 3; ++c) ASSERT_EQ(out[3 * column + c], rgb[2 - c]);
      }
      ASSERT_EQ(out[3 * width], 99) << "what lies beyond is another task's";
    }
  }
}

}  // namespace
}  // namespace raywalk
