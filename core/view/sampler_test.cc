// Samples of stations and their mixing, against double arithmetic.
#include "core/view/sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace raywalk {
namespace {

constexpr std::size_t kGuard = 16;  // bytes around a panorama that may be read
constexpr std::size_t kSamples = 64;
constexpr std::size_t kStride = 5;
constexpr PanoramaSize kSampled{64, 32};

double linear_kernel(double d) { return std::max(0.0, 1.0 - std::fabs(d)); }
// R. Keys' cubic with a = -1/2.
double cubic_kernel(double d) {
  const double t = std::fabs(d);
  return t < 1.0 ? (1.5 * t - 2.5) * t * t + 1.0 : ((-0.5 * t + 2.5) * t - 4.0) * t + 2.0;
}

// A station of random colours and the places of some samples in it: anywhere, beside the seam, and
// at and beyond the poles.
struct SampledStation {
  SampledStation(PanoramaSize panorama, std::mt19937* random) : size(panorama) {
    const auto uniform = [&](double least, double most) {
      return static_cast<float>(std::uniform_real_distribution<double>(least, most)(*random));
    };
    memory.resize(static_cast<std::size_t>(3 * size.width * size.height) + 2 * kGuard, 0xEE);
    for (std::size_t i = kGuard; i + kGuard < memory.size(); ++i) {
      memory[i] = static_cast<std::uint8_t>((*random)());
    }
    const auto width = static_cast<float>(size.width), height = static_cast<float>(size.height);
    const float column = uniform(0.0, 2.0 * width);
    std::array<float, kSamples> from_column;
    for (std::size_t i = 0; i < kSamples; ++i) {
      const float turned = i % 5 == 0 ? 2.0f * width - 1.0f - column + uniform(0.0, 1.0)
                                      : uniform(-0.5 * width, 0.5 * width);
      from_column[i] = std::clamp(turned, -0.5f * width, 0.5f * width);
      v[i] = i % 7 == 0 ? height - 1.0f : uniform(-0.5, height - 0.5);
      asked_u[i] = double(from_column[i]) + column;
      asked_v[i] = v[i];
    }
    weight.fill(1.0f);
    place_samples(from_column.data(), v.data(), kSamples, column, size, u.data(), places());
  }

  SamplePlaces places() { return {left.data(), right.data(), across.data(), down.data()}; }
  StationSamples samples() {
    weigh_samples(v.data(), weight.data(), kSamples, size, down.data());
    return {.pixels = memory.data() + kGuard,
            .at = places(),
            .u = u.data(),
            .v = v.data(),
            .weight = weight.data(),
            .exposure = exposure.empty() ? nullptr : exposure.data(),
            .exposure_step = step};
  }
  // A channel of a pixel: columns around the seam, rows to the poles.
  double level(int column, int row, std::size_t channel) const {
    const int x = (column + size.width) % size.width, y = std::clamp(row, 0, size.height - 1);
    return memory[kGuard + static_cast<std::size_t>(3 * (x * size.height + y)) + channel];
  }
  // Of the i-th sample. Without exposure, bilinear ones are at 1/64 of a column.
  double truth(std::size_t i, std::size_t channel, bool cubic) const {
    const bool exact = cubic || !exposure.empty();
    const auto kernel = cubic ? cubic_kernel : linear_kernel;
    const double x = exact ? double(u[i]) : std::floor(u[i] * 64.0 + 0.5) / 64.0, y = v[i];
    double sum = 0.0;
    for (int column = static_cast<int>(x) - 1; column <= static_cast<int>(x) + 2; ++column) {
      for (int row = static_cast<int>(y) - 1; row <= static_cast<int>(y) + 2; ++row) {
        sum += kernel(x - column) * kernel(y - row) * level(column, row, channel);
      }
    }
    if (exposure.empty()) return sum;
    const auto whole = static_cast<std::size_t>(step);
    const float* const node = exposure.data() + i / whole * 4 + channel;
    return sum * std::lerp(double(node[0]), node[4], double(i % whole) / step);
  }

  PanoramaSize size;
  std::vector<std::uint8_t> memory;
  std::array<double, kSamples> asked_u, asked_v;
  std::array<std::int32_t, kSamples> left, right, across, down;
  std::array<float, kSamples> u, v, weight;
  std::vector<float> exposure;
  int step = 1;  // rows from one exposure to the next
};

class Samples : public testing::Test {
 protected:
  // As the mixing of a view does.
  void mix(std::vector<SampledStation>& stations, bool cubic) {
    std::vector<StationSamples> samples;
    for (SampledStation& each : stations) samples.push_back(each.samples());
    if (cubic || !stations[0].exposure.empty()) {
      mix_exact(samples, cubic, stations[0].size, kSamples, bgr_.data(), kStride);
    } else {
      mix_linear(samples, {}, kSamples, bgr_.data(), kStride);
    }
  }
  int channel(std::size_t i, std::size_t c) const { return bgr_[i * kStride + 2 - c]; }
  float random_weight(float most) {
    return std::uniform_real_distribution<float>(0.0f, most)(random_);
  }

  std::mt19937 random_{5};
  std::vector<std::uint8_t> bgr_ = std::vector<std::uint8_t>(kSamples * kStride + 1);
};

TEST_F(Samples, LieWhereTheyAreAskedForAndAreBilinear) {
  for (const PanoramaSize size : {PanoramaSize{4, 2}, {8, 4}, kSampled, {514, 257}}) {
    for (int n = 0; n < 20; ++n) {
      std::vector<SampledStation> made{SampledStation(size, &random_)};
      mix(made, false);
      for (std::size_t i = 0; i < kSamples; ++i) {
        const double turns = (made[0].u[i] - made[0].asked_u[i]) / size.width;
        ASSERT_NEAR(turns, std::round(turns), 1e-6);
        ASSERT_GE(made[0].u[i], 0.0f);
        ASSERT_LT(made[0].u[i], static_cast<float>(size.width));
        ASSERT_NEAR(made[0].v[i], std::clamp(made[0].asked_v[i], 0.0, size.height - 1.0), 1e-6);
        for (std::size_t c = 0; c < 3; ++c) {
          ASSERT_NEAR(channel(i, c), made[0].truth(i, c, false), 0.52)
              << made[0].u[i] << ", " << made[0].v[i] << " of " << size.width;
        }
      }
    }
  }
}

// One row at a time is computed without AVX2.
TEST_F(Samples, AreTheSameBitsOneByOne) {
  std::vector<SampledStation> made;
  for (int k = 0; k < 3; ++k) {
    made.emplace_back(kSampled, &random_);
    for (float& weight : made.back().weight) weight = random_weight(1.0f / 3.0f);
  }
  mix(made, false);
  std::array<std::uint8_t, 4> bgr{};
  for (std::size_t i = 0; i < kSamples; ++i) {
    std::vector<StationSamples> samples;
    for (SampledStation& each : made) {
      samples.push_back(each.samples());
      SamplePlaces& at = samples.back().at;
      at = {at.left + i, at.right + i, at.across + i, at.down + i};
    }
    mix_linear(samples, {}, 1, bgr.data(), kStride);
    for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(bgr[2 - c], channel(i, c));
  }
}

TEST_F(Samples, OfSeveralStationsAreMixedByWeightLinearOrCubicAndExposed) {
  for (const int stations : {2, 3, 5}) {
    for (const bool exposed : {false, true}) {
      for (const bool cubic : {false, true}) {
        std::vector<SampledStation> made;
        for (int k = 0; k < stations; ++k) made.emplace_back(kSampled, &random_);
        for (std::size_t i = 0; i < kSamples; ++i) {
          float left = 1.0f;
          for (SampledStation& each : made) {
            each.weight[i] = &each == &made.back() ? left : random_weight(left);
            left -= each.weight[i];
          }
        }
        std::uniform_real_distribution<float> factor(0.5f, 1.2f);
        for (SampledStation& each : made) {
          each.step = &each == &made.front() ? 1 : kExposureStep;
          each.exposure.resize(exposed ? 4 * (kSamples + 2) : 0);
          for (float& each_factor : each.exposure) each_factor = factor(random_);
        }
        mix(made, cubic);
        for (std::size_t i = 0; i < kSamples; ++i) {
          for (std::size_t c = 0; c < 3; ++c) {
            double truth = 0.0;
            for (const SampledStation& each : made) {
              truth += each.truth(i, c, cubic) * each.weight[i];
            }
            ASSERT_NEAR(channel(i, c), std::clamp(truth, 0.0, 255.0), 0.52)
                << stations << (exposed ? " exposed" : "") << (cubic ? " cubic" : "");
          }
        }
      }
    }
  }
}

// Ten stations see about the same, two something else.
TEST_F(Samples, ThatContradictManyOthersCountLess) {
  std::vector<SampledStation> made;
  for (int k = 0; k < 12; ++k) {
    made.emplace_back(kSampled, &random_);
    std::ranges::fill(made.back().memory, static_cast<std::uint8_t>(k < 10 ? 95 + k : 230));
    made.back().weight.fill(1.0f / 12.0f);
  }
  mix(made, true);
  EXPECT_NEAR(channel(0, 0), 99.5, 2.0) << "where the mean is 121";
  made.erase(made.end() - 2, made.end());
  mix(made, true);
  EXPECT_NEAR(channel(0, 0), 99.5, 1.0) << "all agree";
}

TEST_F(Samples, WhiteStaysWhiteAndBlackBlack) {
  for (const int level : {0, 255}) {
    for (const int stations : {1, 2, 9}) {
      std::vector<SampledStation> made;
      for (int k = 0; k < stations; ++k) {
        made.emplace_back(kSampled, &random_);
        std::ranges::fill(made.back().memory, static_cast<std::uint8_t>(level));
        made.back().weight.fill(1.0f / static_cast<float>(stations));
      }
      for (const bool cubic : {false, true}) {
        mix(made, cubic);
        for (std::size_t i = 0; i < kSamples; ++i) ASSERT_EQ(channel(i, i % 3), level);
      }
    }
  }
}

}  // namespace
}  // namespace raywalk
