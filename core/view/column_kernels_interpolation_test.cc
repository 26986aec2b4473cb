// Kernels that read the nearest pixel or 4 x 4 pixels, against a direct evaluation in double.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <vector>

#include "core/view/column_kernels.h"
#include "core/view/test_columns.h"

namespace raywalk {
namespace {

// Rays between two unreadable pages: at the end of the readable ones, or at their beginning except
// for the two bytes that kernels may read.
class GuardedRays {
 public:
  GuardedRays(std::span<const std::uint8_t> bytes, bool at_end) {
    const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    const size_t readable = (bytes.size() + 2 + page - 1) / page * page;
    size_ = readable + 2 * page;
    memory_ = static_cast<std::uint8_t*>(
        mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    mprotect(memory_, page, PROT_NONE);
    mprotect(memory_ + page + readable, page, PROT_NONE);
    rays_ = memory_ + page + (at_end ? readable - bytes.size() : 2);
    std::copy(bytes.begin(), bytes.end(), rays_);
  }
  ~GuardedRays() { munmap(memory_, size_); }
  GuardedRays(const GuardedRays&) = delete;
  GuardedRays& operator=(const GuardedRays&) = delete;

  const std::uint8_t* data() const { return rays_; }

 private:
  std::uint8_t* memory_ = nullptr;
  std::uint8_t* rays_ = nullptr;
  size_t size_ = 0;
};

double keys(double distance) {
  const double x = std::fabs(distance);
  if (x < 1.0) return (1.5 * x - 2.5) * x * x + 1.0;
  return x < 2.0 ? ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0 : 0.0;
}

// A panorama and positions in it.
struct Places {
  PanoramaSize size;
  std::vector<std::uint8_t> rays;  // [column][row][rgb]
  std::vector<double> u, v;

  int count() const { return static_cast<int>(u.size()); }
  double level(int column, int row, int channel) const {
    const int wrapped = ((column % size.width) + size.width) % size.width;
    const int kept = std::clamp(row, 0, size.height - 1);
    const int offset = (wrapped * size.height + kept) * 3 + channel;
    return rays[static_cast<size_t>(offset)];
  }
  // Keys' cubic over all pixels around.
  double cubic(size_t i, int channel) const {
    const int left = static_cast<int>(std::floor(u[i]));
    const int upper = static_cast<int>(std::floor(v[i]));
    double sum = 0.0;
    for (int column = left - 1; column <= left + 2; ++column) {
      for (int row = upper - 1; row <= upper + 2; ++row) {
        sum += keys(u[i] - column) * keys(v[i] - row) * level(column, row, channel);
      }
    }
    return sum;
  }
  SampleArrays positions() const {
    SampleArrays at(count());
    for (size_t i = 0; i < u.size(); ++i) {
      const int left = static_cast<int>(std::floor(u[i]));
      const int upper = std::min(static_cast<int>(std::floor(v[i])), size.height - 2);
      at.left[i] = (left * size.height + upper) * 3;
      at.right[i] = ((left + 1) % size.width * size.height + upper) * 3;
      const auto weight = [](double part) {
        return twice_weight(std::min(static_cast<int>(std::lround(part * 32768.0)), 32767));
      };
      at.weight_right[i] = weight(u[i] - left);
      at.weight_lower[i] = weight(v[i] - upper);
    }
    return at;
  }
  RayExtent extent() const { return {3 * size.height, 3 * size.height * size.width}; }
};

// Random positions in steps of 1/1024 of a pixel, including the poles and the seam.
Places random_places(RandomColumns* random, PanoramaSize size, int count) {
  Places places{.size = size,
                .rays = random->bytes(3 * static_cast<size_t>(size.width * size.height)),
                .u = {},
                .v = {}};
  const auto on_step = [](double x) { return std::floor(x * 1024.0) / 1024.0; };
  for (int i = 0; i < count; ++i) {
    places.u.push_back(on_step(random->uniform(0.0, size.width)));
    places.v.push_back(
        std::clamp(on_step(random->uniform(-1.0, size.height)), 0.0, size.height - 1.0));
  }
  return places;
}

std::uint8_t to_byte(double level) {
  return static_cast<std::uint8_t>(std::clamp(std::floor(level + 0.5), 0.0, 255.0));
}

class KernelInterpolation : public Kernels {};
INSTANTIATE_TEST_SUITE_P(Sets, KernelInterpolation, testing::Values("generic", "avx2"),
                         kernel_set_name);

const PanoramaSize kSizes[] = {{4, 2}, {6, 3}, {8, 4}, {34, 17}};

TEST_P(KernelInterpolation, CubicIsKeysInRowsAndColumnsAroundTheSeamAndTheRowsOfThePoles) {
  for (const PanoramaSize size : kSizes) {
    for (const bool at_end : {false, true}) {
      const Places places = random_places(&random_, size, 997);
      const GuardedRays rays(places.rays, at_end);
      SampleArrays at = places.positions();
      StationSamples samples = at.of(rays.data());
      samples.extent = places.extent();
      std::vector<std::uint8_t> rgb(size_t{3} * 997 + 1);
      kernels_->cubic.sample_each(samples, 997, rgb.data());
      for (size_t i = 0; i < 997; ++i) {
        for (int c = 0; c < 3; ++c) {
          const double exact = std::clamp(places.cubic(i, c), 0.0, 255.0);
          ASSERT_NEAR(rgb[3 * i + static_cast<size_t>(c)], exact, 0.5 + 0.07)
              << size.width << " at " << places.u[i] << ',' << places.v[i];
        }
      }
    }
  }
}

TEST_P(KernelInterpolation, CubicIsExactWhereLevelsAreQuadratic) {
  // Triangular numbers are quadratic and whole.
  Places places{.size = {14, 15}, .rays = {}, .u = {}, .v = {}};
  const auto triangular = [](double x) { return x * (x - 1.0) / 2.0; };
  for (int column = 0; column < 14; ++column) {
    for (int row = 0; row < 15; ++row) {
      for (const double level :
           {triangular(column) + triangular(row), 200.0 - triangular(column), column * row * 1.0}) {
        places.rays.push_back(static_cast<std::uint8_t>(level));
      }
    }
  }
  for (int i = 0; i < 500; ++i) {
    places.u.push_back(random_.uniform(1.0, 11.9));
    places.v.push_back(random_.uniform(1.0, 12.9));
  }
  SampleArrays at = places.positions();
  StationSamples samples = at.of(places.rays.data());
  samples.extent = places.extent();
  // Sums in 1/64 level show more than bytes do.
  const std::vector<std::int16_t> weight(500, 32767);
  std::vector<std::int16_t> sum(size_t{4} * 500);
  kernels_->cubic.accumulate_each(samples, weight.data(), 500, sum.data());
  for (size_t i = 0; i < 500; ++i) {
    const double u = places.u[i];
    const double v = places.v[i];
    // 1/2048 of a pixel on slopes of up to 14 levels a pixel, and some rounding.
    constexpr double kTolerance = 2 * 14.0 / 2048.0 + 3.0 / 64.0;
    EXPECT_NEAR(sum[4 * i] / 64.0, triangular(u) + triangular(v), kTolerance);
    EXPECT_NEAR(sum[4 * i + 1] / 64.0, 200.0 - triangular(u), kTolerance);
    EXPECT_NEAR(sum[4 * i + 2] / 64.0, u * v, kTolerance);
  }
}

TEST_P(KernelInterpolation, NearestIsThePixelAroundThePosition) {
  for (const PanoramaSize size : kSizes) {
    for (const bool at_end : {false, true}) {
      const Places places = random_places(&random_, size, 997);
      const GuardedRays rays(places.rays, at_end);
      SampleArrays at = places.positions();
      std::vector<std::uint8_t> rgb(size_t{3} * 997 + 1);
      kernels_->nearest.sample_each(at.of(rays.data()), 997, rgb.data());
      for (size_t i = 0; i < 997; ++i) {
        const int column = static_cast<int>(std::floor(places.u[i] + 0.5));
        const int row = static_cast<int>(std::floor(places.v[i] + 0.5));
        for (int c = 0; c < 3; ++c) {
          ASSERT_EQ(rgb[3 * i + static_cast<size_t>(c)], places.level(column, row, c))
              << size.width << " at " << places.u[i] << ',' << places.v[i];
        }
      }
    }
  }
}

// Samples of one station, in levels, with overshoot.
using Levels = std::vector<double>;
Levels levels_of(const SampleReaders& readers, StationSamples samples, int rows) {
  const std::vector<std::int16_t> whole(static_cast<size_t>(rows), 32767);
  std::vector<std::int16_t> sum(size_t{4} * static_cast<size_t>(rows));
  readers.accumulate_each(samples, whole.data(), rows, sum.data());
  return Levels(sum.begin(), sum.end());
}

TEST_P(KernelInterpolation, PairsAndSumsAreMixesOfSingleSamples) {
  const Places one = random_places(&random_, {20, 10}, 999);
  const Places other = random_places(&random_, {20, 10}, 999);
  std::vector<std::uint8_t> padded(2);
  padded.insert(padded.end(), one.rays.begin(), one.rays.end());
  SampleArrays at = one.positions();
  SampleArrays beside = other.positions();
  StationSamples first = at.of(padded.data() + 2);
  StationSamples second = beside.of(padded.data() + 2);
  first.extent = second.extent = one.extent();
  std::vector<std::int16_t> weight = random_.weights(999);
  for (const SampleReaders* readers : {&kernels_->nearest, &kernels_->linear, &kernels_->cubic}) {
    const Levels a = levels_of(*readers, first, 999);
    const Levels b = levels_of(*readers, second, 999);
    for (const std::int16_t share : {0, 9000, 32767}) {
      std::vector<std::uint8_t> rgb(size_t{3} * 999 + 1);
      std::vector<std::int16_t> sum(size_t{4} * 999, 500);
      std::vector<std::int16_t> alone(sum);
      readers->mix_pair(first, second, share, 999, rgb.data());
      readers->accumulate_pair(first, second, share, weight.data(), 999, sum.data());
      readers->accumulate_each(first, weight.data(), 999, alone.data());
      for (size_t row = 0; row < 999; ++row) {
        for (size_t c = 0; c < 3; ++c) {
          const size_t i = 4 * row + c;
          const double mixed = a[i] + (b[i] - a[i]) * share / 32768.0;
          ASSERT_NEAR(rgb[3 * row + c], to_byte(mixed / 64.0), 1.0);
          ASSERT_NEAR(sum[i] - 500, mixed * weight[row] / 32768.0, 2.5);
          ASSERT_NEAR(alone[i] - 500, a[i] * weight[row] / 32768.0, 1.5);
        }
      }
    }
  }
}

TEST_P(KernelInterpolation, RowsWithoutWeightAreNotRead) {
  SampleArrays far(3);
  std::ranges::fill(far.left, 2000000000);  // nothing is mapped there
  std::ranges::fill(far.right, 2000000000);
  const std::vector<std::int16_t> weight(3, 0);
  const std::uint8_t nothing[8] = {};
  StationSamples samples = far.of(nothing);
  samples.extent = {6, 8};
  for (const SampleReaders* readers : {&kernels_->nearest, &kernels_->linear, &kernels_->cubic}) {
    std::vector<std::int16_t> sum(12, 77);
    readers->accumulate_each(samples, weight.data(), 3, sum.data());
    readers->accumulate_pair(samples, samples, 5, weight.data(), 3, sum.data());
    EXPECT_EQ(sum, std::vector<std::int16_t>(12, 77));
  }
}

TEST_P(KernelInterpolation, AUniformSurfaceIsPreserved) {
  for (const int level : {0, 1, 128, 255}) {
    Places places = random_places(&random_, {20, 10}, 301);
    std::ranges::fill(places.rays, static_cast<std::uint8_t>(level));
    SampleArrays at = places.positions();
    std::vector<std::uint8_t> padded(places.rays.size() + 2, static_cast<std::uint8_t>(level));
    StationSamples samples = at.of(padded.data() + 2);
    samples.extent = places.extent();
    for (const SampleReaders* readers : {&kernels_->nearest, &kernels_->cubic}) {
      std::vector<std::uint8_t> rgb(size_t{3} * 301 + 1);
      readers->mix_pair(samples, samples, 11111, 301, rgb.data());
      rgb.pop_back();
      EXPECT_EQ(rgb, std::vector<std::uint8_t>(size_t{3} * 301, static_cast<std::uint8_t>(level)));
    }
  }
}

TEST(KernelInterpolationIdentity, BothSetsReadTheSame) {
  const ColumnKernels* generic = column_kernels_named("generic");
  const ColumnKernels* avx2 = column_kernels_named("avx2");
  if (avx2 == nullptr) GTEST_SKIP() << "this processor has no AVX2";
  RandomColumns random(5);
  const std::vector<SampleReaders ColumnKernels::*> ways = {
      &ColumnKernels::nearest, &ColumnKernels::linear, &ColumnKernels::cubic};
  for (const PanoramaSize size : kSizes) {
    const Places one = random_places(&random, size, 1021);
    const Places other = random_places(&random, size, 1021);
    std::vector<std::uint8_t> padded(2);
    padded.insert(padded.end(), one.rays.begin(), one.rays.end());
    SampleArrays at = one.positions();
    SampleArrays beside = other.positions();
    for (SampleArrays* arrays : {&at, &beside}) {  // fractions of any kind
      for (auto& weight : arrays->weight_right) {
        weight = twice_weight(static_cast<int>(random.uniform(0.0, 32768.0)));
      }
    }
    StationSamples first = at.of(padded.data() + 2);
    StationSamples second = beside.of(padded.data() + 2);
    first.extent = second.extent = one.extent();
    const std::vector<std::int16_t> weight = random.weights(1021);
    for (const auto way : ways) {
      const auto results = [&](const ColumnKernels& kernels) {
        const SampleReaders& readers = kernels.*way;
        std::vector<std::uint8_t> rgb(size_t{6} * 1021 + 1);
        std::vector<std::int16_t> sum(size_t{4} * 1021);
        readers.mix_pair(first, second, 9999, 1021, rgb.data());
        readers.sample_each(first, 1021, rgb.data() + size_t{3} * 1021);
        readers.accumulate_pair(first, second, 9999, weight.data(), 1021, sum.data());
        readers.accumulate_each(second, weight.data(), 1021, sum.data());
        for (size_t i = 0; i < 1021; ++i) {
          for (size_t c = 0; c < 3; ++c) {
            rgb.push_back(static_cast<std::uint8_t>(sum[4 * i + c] & 0xff));
            rgb.push_back(static_cast<std::uint8_t>((sum[4 * i + c] >> 8) & 0xff));
          }
        }
        rgb[size_t{6} * 1021] = 0;  // scratch
        return rgb;
      };
      EXPECT_EQ(results(*generic), results(*avx2)) << size.width;
    }
  }
}

}  // namespace
}  // namespace raywalk
