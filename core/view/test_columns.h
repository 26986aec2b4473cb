// For tests: random columns as the kernels take them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/view/column_arrays.h"
#include "core/view/column_kernels.h"

namespace raywalk {

// Arrays for `rows` rows that find_samples writes; the offsets are longer, since the kernels
// prefetch by them.
class SampleArrays {
 public:
  explicit SampleArrays(int rows)
      : left(static_cast<size_t>(rows + kSampleLookAhead)),
        right(left.size()),
        weight_right(static_cast<size_t>(rows)),
        weight_lower(weight_right.size()) {}
  SamplePositions positions() {
    return {left.data(), right.data(), weight_right.data(), weight_lower.data()};
  }
  // With the rays they lie in.
  StationSamples of(const std::uint8_t* rays) {
    StationSamples samples;
    samples.rays = rays;
    samples.positions = positions();
    return samples;
  }
  bool operator==(const SampleArrays&) const = default;

  std::vector<std::int32_t> left, right;
  std::vector<std::int32_t> weight_right, weight_lower;
};

// Shifts of `count` rows, padded with NaN; there is something between all of them.
struct ShiftArrays {
  explicit ShiftArrays(int count)
      : u(static_cast<size_t>(count + kShiftPadding), std::numeric_limits<float>::quiet_NaN()),
        v(u),
        no_between(u.size()) {}
  // As those of row `first` and the following ones, of `rows`.
  ShiftedRows from(int first, int rows, int per_row) const {
    return {u.data(), v.data(), no_between.data(), first, rows, per_row};
  }

  std::vector<float> u, v;
  std::vector<std::int32_t> no_between;
};

class RandomColumns {
 public:
  explicit RandomColumns(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  // Inverse distances, log-uniform over 1e-6..1e6 1/m, one in ten infinitely far.
  std::vector<float> omegas(int rows) {
    std::vector<float> omega;
    for (int i = 0; i < rows; ++i) {
      const double value = std::pow(10.0, uniform(-6.0, 6.0));
      omega.push_back(uniform(0.0, 1.0) < 0.1 ? 0.0f : static_cast<float>(value));
    }
    return omega;
  }
  // Inverse distances of a room: 0.3 to 12 m.
  std::vector<float> room_omegas(int rows) {
    std::vector<float> omega;
    for (int i = 0; i < rows; ++i) omega.push_back(static_cast<float>(1.0 / uniform(0.3, 12.0)));
    return omega;
  }
  ColumnOffset offset(double size_m) {
    const auto one = [&] { return static_cast<float>(uniform(-size_m, size_m)); };
    return {one(), 0.1f * one(), 0.3f * one()};
  }
  std::vector<std::uint8_t> bytes(size_t count) {
    std::vector<std::uint8_t> bytes(count);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random_());
    return bytes;
  }
  // Interpolation weights in 1/32768; both ends occur.
  std::vector<std::int16_t> weights(int count) {
    std::vector<std::int16_t> weights;
    weights.reserve(static_cast<size_t>(count));
    for (int i = 0; i < count; ++i) {
      const double value = uniform(-3000.0, 35767.0);
      weights.push_back(static_cast<std::int16_t>(std::clamp(value, 0.0, 32767.0)));
    }
    return weights;
  }
  // Positions within rays of `columns` columns of `height` rows.
  SampleArrays samples(int rows, int columns, int height) {
    SampleArrays samples(rows);
    for (int i = 0; i < rows; ++i) {
      const auto at = static_cast<size_t>(i);
      const int upper = static_cast<int>(uniform(0.0, height - 1.0));
      samples.left[at] = (static_cast<int>(uniform(0.0, columns)) * height + upper) * 3;
      samples.right[at] = (static_cast<int>(uniform(0.0, columns)) * height + upper) * 3;
    }
    const auto twice = [](int weight) { return twice_weight(weight); };
    std::ranges::transform(weights(rows), samples.weight_right.begin(), twice);
    std::ranges::transform(weights(rows), samples.weight_lower.begin(), twice);
    return samples;
  }

 private:
  std::mt19937_64 random_;
};

// Tests of one set of kernels after the other; the parameter is their name.
class Kernels : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (kernels_ == nullptr) GTEST_SKIP() << "not on this processor";
  }
  const ColumnKernels* kernels_ = column_kernels_named(GetParam());
  RandomColumns random_{31};
};

inline std::string kernel_set_name(const testing::TestParamInfo<const char*>& set) {
  return set.param;
}

}  // namespace raywalk
