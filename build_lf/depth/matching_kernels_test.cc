#include "build_lf/depth/matching_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "build_lf/depth/pixel_directions.h"
#include "core/geometry/test_pixels.h"

namespace raywalk::build_lf {
namespace {

constexpr int kWidth = 128;
constexpr int kHeight = 64;

// A station's picture with smooth samples, or with `noise` random ones.
std::vector<MatchingSample> picture(bool noise, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<MatchingSample> samples;
  for (const auto [u, v] : pixels_of({kWidth, kHeight})) {
    samples.push_back(noise ? MatchingSample(random())
                            : matching_sample(unsigned(u), unsigned(2 * v), unsigned(u / 2 + v),
                                              unsigned(1 + v)));
  }
  return samples;
}

// A column of the reference.
struct Column {
  std::vector<float> x, y, z;
  std::vector<MatchingSample> samples;

  Column(double theta_rad, int rows, unsigned seed) {
    std::mt19937 random(seed);
    for (int row = 0; row < rows; ++row) {
      const Eigen::Vector3d direction =
          direction_from_angles({theta_rad, kHalfPi - (row + 0.5) / rows * kPi});
      x.push_back(static_cast<float>(direction.x()));
      y.push_back(static_cast<float>(direction.y()));
      z.push_back(static_cast<float>(direction.z()));
      samples.push_back(static_cast<MatchingSample>(random()));
    }
  }
  ReferenceRays rays() const {
    return {x.data(), y.data(), z.data(), samples.data(), static_cast<int>(samples.size())};
  }
};

int difference_of(MatchingSample sample, MatchingSample own) {
  if (channel_of(sample, 3) == static_cast<int>(kInvalidDetail)) return kInvalidDifference;
  int colour = 0;
  for (int c = 0; c < 3; ++c) colour += std::abs(channel_of(sample, c) - channel_of(own, c));
  const int detail = std::abs(channel_of(sample, 3) - channel_of(own, 3));
  return std::min(3 * colour, 200) + std::min(detail, 64);
}

// A random offset: any direction, lengths from far to near.
Eigen::Vector3d random_offset(std::mt19937* random) {
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  std::uniform_real_distribution<double> exponent(-4.0, 1.0);
  return std::pow(10.0, exponent(*random)) *
         direction_from_angles({angle(*random), 0.5 * angle(*random)});
}

ViewSamples view_of(const std::vector<MatchingSample>& samples, const Eigen::Vector3d& offset) {
  return {.samples = samples.data(),
          .width = kWidth,
          .height = kHeight,
          .offset_x = static_cast<float>(offset.x()),
          .offset_y = static_cast<float>(offset.y()),
          .offset_z = static_cast<float>(offset.z())};
}

TEST(MatchingKernelsTest, CompareTheProjectedSample) {
  const auto samples = picture(true, 1);
  const MatchingKernels& kernels = *matching_kernels_named("generic");
  std::mt19937 random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const double theta_rad = -kPi + (trial + 0.5) / 200.0 * kTwoPi;
    const Column column(theta_rad, 61, unsigned(trial));
    const Eigen::Vector3d offset = random_offset(&random);
    std::vector<std::int32_t> difference(column.samples.size(), 1000);
    kernels.compare(column.rays(), view_of(samples, offset), difference.data());
    for (size_t row = 0; row < difference.size(); ++row) {
      const double phi_rad = kHalfPi - (double(row) + 0.5) / 61.0 * kPi;
      const SphereAngles seen =
          angles_from_direction(direction_from_angles({theta_rad, phi_rad}) + offset);
      const double u = (seen.theta_rad + kPi) / kTwoPi * kWidth;
      const double v = (kHalfPi - seen.phi_rad) / kPi * kHeight;
      // Single precision may round to the other sample half way between two; theta is undefined at
      // a pole.
      constexpr double kRounding = 2e-4;
      const auto between = [&](double place) {
        return std::fabs(place - std::round(place)) < kRounding;
      };
      if (between(u) || between(v) || v < 0.05 || v > kHeight - 0.05) continue;
      const auto sample =
          samples[static_cast<size_t>(static_cast<int>(u) * kHeight) + static_cast<size_t>(v)];
      ASSERT_EQ(difference[row], difference_of(sample, column.samples[row]))
          << "trial " << trial << " row " << row;
    }
  }
}

TEST(MatchingKernelsTest, StayInBoundsForExtremeOffsets) {
  const auto samples = picture(false, 1);
  const MatchingKernels& kernels = matching_kernels();
  for (const double length : {0.0, 1e-30, 1.0, 1e10, 1e30}) {
    for (int trial = 0; trial < 50; ++trial) {
      const Column column(-kPi + trial * 0.126, 40, unsigned(trial));
      const Eigen::Vector3d offset =
          -length * direction_from_angles({-kPi + trial * 0.126, 1.57 - trial * 0.06});
      std::vector<std::int32_t> difference(column.samples.size(), 0);
      kernels.compare(column.rays(), view_of(samples, offset), difference.data());
      for (const auto value : difference) {
        ASSERT_GE(value, 0);
        ASSERT_LE(value, kInvalidDifference);
      }
    }
  }
}

// A straightforward reference implementation of semi-global matching.
std::vector<int> extended(const std::vector<std::uint8_t>& cost,
                          const std::vector<std::uint16_t>& previous, int small_step,
                          int large_step) {
  const int least = *std::min_element(previous.begin(), previous.end());
  std::vector<int> path;
  const int layers = static_cast<int>(cost.size());
  for (int k = 0; k < layers; ++k) {
    int best = least + large_step;
    for (int from = std::max(0, k - 1); from <= std::min(layers - 1, k + 1); ++from) {
      best = std::min(best, previous[from] + (from == k ? 0 : small_step));
    }
    path.push_back(cost[k] + best - least);
  }
  return path;
}

class MatchingKernelSets : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (kernels_ == nullptr) GTEST_SKIP() << "this processor cannot run " << GetParam();
  }
  const MatchingKernels* kernels_ = matching_kernels_named(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Sets, MatchingKernelSets, ::testing::Values("generic", "avx2", "avx512"));

TEST_P(MatchingKernelSets, ExtendAPathAsTheReferenceDoes) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 500; ++trial) {
    const size_t layers = 16 * (1 + random() % 12);
    std::vector<std::uint8_t> cost(layers);
    std::vector<std::uint16_t> previous(layers);
    for (auto& value : cost) value = static_cast<std::uint8_t>(random() % 177);
    for (auto& value : previous) value = static_cast<std::uint16_t>(random() % 2000);
    std::vector<std::uint16_t> padded(layers + 2, 30000);
    std::copy(previous.begin(), previous.end(), padded.begin() + 1);
    std::vector<std::uint16_t> path(layers);
    std::vector<std::uint16_t> sum(layers, 11);
    const auto small_step = static_cast<std::uint16_t>(1 + random() % 30);
    const auto large_step = static_cast<std::uint16_t>(small_step + random() % 200);
    const std::uint16_t least = kernels_->extend_path(
        cost.data(), padded.data() + 1, *std::min_element(previous.begin(), previous.end()),
        small_step, large_step, static_cast<int>(layers), path.data(), sum.data());
    const std::vector<int> expected = extended(cost, previous, small_step, large_step);
    ASSERT_EQ(std::vector<int>(path.begin(), path.end()), expected);
    ASSERT_EQ(least, *std::min_element(expected.begin(), expected.end()));
    for (size_t k = 0; k < layers; ++k) ASSERT_EQ(sum[k], 11 + expected[k]);
  }
}

TEST_P(MatchingKernelSets, DoTheSameArithmetic) {
  const MatchingKernels* generic = matching_kernels_named("generic");
  const auto samples = picture(true, 4);
  std::mt19937 random(5);
  for (int trial = 0; trial < 500; ++trial) {
    const int rows = 1 + static_cast<int>(random() % 70);
    const Column column(-kPi + trial * kTwoPi / 500.0, rows, unsigned(trial));
    const ViewSamples view = view_of(samples, random_offset(&random));
    std::vector<std::int32_t> a(column.samples.size(), 3);
    std::vector<std::int32_t> b(column.samples.size(), 3);
    generic->compare(column.rays(), view, a.data());
    kernels_->compare(column.rays(), view, b.data());
    ASSERT_EQ(a, b) << "trial " << trial;
  }
}

TEST_P(MatchingKernelSets, AverageTheBetterHalfAndAllOfTheViews) {
  std::mt19937 random(6);
  std::array<ViewDifferences, kMaxViews> differences{};
  for (int trial = 0; trial < 200; ++trial) {
    const int views = 1 + trial % kMaxViews;
    const int count = 1 + static_cast<int>(random() % kTilePixels);
    for (auto& of_view : differences) {
      for (auto& value : of_view) value = static_cast<std::int32_t>(random() % 265);
    }
    std::vector<float> mean(kTilePixels, -1.0f);
    kernels_->average_views(differences, views, count, mean.data());
    for (size_t i = 0; i < mean.size(); ++i) {
      if (i >= static_cast<size_t>(count)) {
        ASSERT_EQ(mean[i], -1.0f);
        continue;
      }
      std::vector<int> values;
      for (size_t v = 0; v < static_cast<size_t>(views); ++v) values.push_back(differences[v][i]);
      std::sort(values.begin(), values.end());
      const int kept = (views + 1) / 2;
      const double better = std::accumulate(values.begin(), values.begin() + kept, 0.0) / kept;
      const double all = std::accumulate(values.begin(), values.end(), 0.0) / views;
      ASSERT_NEAR(mean[i], better + 0.25 * (all - better), 1e-3) << views << " views";
    }
  }
}

// Points in all directions at 1e-6 to 1e8 of the scale, and along the axes.
std::vector<Eigen::Vector3f> points_at_all_scales() {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  std::uniform_real_distribution<double> exponent(-6.0, 8.0);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d direction = direction_from_angles({angle(random), 0.5 * angle(random)});
    points.push_back((std::pow(10.0, exponent(random)) * direction).cast<float>());
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const float length : {0.0f, 1e-6f, 1.0f, 1e8f}) {
      points.push_back(length * Eigen::Vector3f::Unit(axis));
      points.push_back(-length * Eigen::Vector3f::Unit(axis));
    }
  }
  return points;
}

TEST_P(MatchingKernelSets, LocatePointsAsPixelOfDoes) {
  const std::vector<Eigen::Vector3f> points = points_at_all_scales();
  std::vector<float> x, y, z, length(points.size());
  for (const Eigen::Vector3f& point : points) {
    x.push_back(point.x());
    y.push_back(point.y());
    z.push_back(point.z());
  }
  for (const PanoramaSize size : {PanoramaSize{2, 1}, {100, 50}, {1024, 512}, {8192, 4096}}) {
    std::vector<std::int32_t> pixel(points.size(), -1);
    kernels_->locate({x.data(), y.data(), z.data(), static_cast<int>(points.size())}, size.width,
                     size.height, pixel.data(), length.data());
    for (size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(size_t(pixel[i]), pixel_of(points[i], size)) << points[i].transpose();
      ASSERT_NEAR(length[i], points[i].cast<double>().norm(), 3e-7 * length[i]);
    }
  }
}

}  // namespace
}  // namespace raywalk::build_lf
