// The columns of a view: where their points lie in stations, which stations are read, and how
// samples are mixed, against double arithmetic.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "core/view/column_geometry.h"
#include "core/view/column_rows.h"
#include "core/view/column_sources.h"
#include "core/view/row_map.h"
#include "core/view/sampler.h"
#include "core/view/test_grid.h"

namespace raywalk {
namespace {

using Eigen::Vector3d;

class RandomPoints {
 public:
  double uniform(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }
  double log_uniform(double least, double most) {
    return std::exp(uniform(std::log(least), std::log(most)));
  }
  Vector3d place(double reach_m) {
    return {uniform(-reach_m, reach_m), uniform(-reach_m, reach_m), uniform(-reach_m, reach_m)};
  }

 private:
  std::mt19937_64 random_{17};
};

// From 1 nm to 1,000,000 km and infinitely far, from stations micrometres and kilometres away.
TEST(ColumnGeometryProperty, PointsLieInStationsWhereDoubleArithmeticSaysTheyDo) {
  RandomPoints random;
  for (int i = 0; i < 200000; ++i) {
    const double inverse = i % 50 == 0 ? 0.0 : random.log_uniform(1e-9, 1e9);
    const Vector3d eye_m = random.place(random.log_uniform(1e-6, 1e3));
    const Vector3d station_m =
        i % 30 == 0 ? eye_m : eye_m + random.place(random.log_uniform(1e-6, 1e3));
    const SphereAngles at{random.uniform(-kPi, kPi), random.uniform(-kHalfPi, kHalfPi)};
    const auto sin_phi = static_cast<float>(std::sin(at.phi_rad));
    const auto cos_phi = static_cast<float>(std::cos(at.phi_rad));
    const SeenPoint seen = seen_from(sin_phi, cos_phi, static_cast<float>(inverse),
                                     offset_in_column(eye_m - station_m, at.theta_rad));

    const Vector3d r = direction_from_angles(at) + inverse * (eye_m - station_m);
    const SphereAngles truth = angles_from_direction(r);
    // What one step of a float of the largest summand turns the direction by: a station right
    // beside the point sees it in any direction.
    const double step = std::ldexp(1.0, -23) * (1.0 + inverse * (eye_m - station_m).norm());
    const double exact_rad = 1.5e-6 + 4.0 * step / r.norm();
    if (exact_rad > 0.1) continue;
    ASSERT_NEAR(seen.phi_rad, truth.phi_rad, exact_rad) << inverse << " 1/m";
    const double turned = wrap_angle(at.theta_rad + seen.turn_rad - truth.theta_rad);
    ASSERT_LE(std::fabs(turned) * std::hypot(r.x(), r.z()), exact_rad * r.norm())
        << inverse << " 1/m";
    ASSERT_NEAR(seen.length, r.norm(), 1e-6 * r.norm() + 4.0 * step);
  }
}

// Of a two-sided view between a line in front and one behind.
double share_behind(double front_m, double behind_m, SecondSide second_side) {
  ColumnPlan plan;
  plan.front_count = plan.behind_count = 1;
  plan.front[0] = {.line = 0, .d_p_m = front_m};
  plan.behind[0] = {.line = 2, .d_p_m = -behind_m};
  const ColumnSources sources =
      column_sources(plan, {.method = ViewMethod::kTwoSided, .second_side = second_side});
  EXPECT_EQ(sources.count, 2U);
  EXPECT_TRUE(sources.source[1].behind());
  return sources.source[1].share;
}

TEST(ColumnSourcesProperty, SharesAddUpToOneAtAnyViewpoint) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-0.5, 0.5), k_deg(45.0, 90.0);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const Grid grid = square_grid(scale, 0.25 * scale);
    for (int view = 0; view < 60; ++view) {
      // Now and then on a line, and on a corner.
      const PlanPoint at{scale * (view % 3 == 0 ? 0.5 : place(random)),
                         scale * (view % 9 == 0 ? -0.5 : place(random))};
      const ViewPlan plan(grid, at, {radians_from_degrees(k_deg(random)), 0.2});
      const ViewOptions options{
          .method = view % 2 == 0 ? ViewMethod::kTwoSided : ViewMethod::kHlfVd,
          .second_side = view % 4 < 2 ? SecondSide::kEverywhere : SecondSide::kFaded};
      const bool both = options.method == ViewMethod::kTwoSided;
      for (int degree = 0; degree < 360; ++degree) {
        const ColumnPlan column = plan.column(radians_from_degrees(degree + 0.1));
        const ColumnSources sources = column_sources(column, options);
        ASSERT_EQ(static_cast<int>(sources.count),
                  column.front_count + (both ? column.behind_count : 0));
        double sum = 0.0;
        for (const ColumnSource& source : std::span(sources.source).first(sources.count)) {
          ASSERT_GT(source.share, 0.0f) << "what only it sees is read from it";
          sum += source.share;
        }
        ASSERT_NEAR(sum, 1.0, 2e-4);  // a side that is faded out leaves a trace
      }
    }
  }
}

TEST(ColumnSources, SidesCountByNearnessAndLinesOfABlendByTheirWeights) {
  for (const double front_m : {1e-6, 0.1, 0.5, 2.0}) {
    for (const double behind_m : {1e-6, 0.3, 1.0}) {
      EXPECT_NEAR(share_behind(front_m, behind_m, SecondSide::kEverywhere),
                  front_m / (front_m + behind_m), 2e-4);
    }
  }
  ColumnPlan plan;
  plan.front_count = 2;
  plan.front[0] = {.line = 0, .d_p_m = 0.7, .weight = 0.25};
  plan.front[1] = {.line = 1, .d_p_m = 0.7, .weight = 0.75};
  EXPECT_NEAR(column_sources(plan, {}).source[1].share, 0.75, 1e-6);
}

TEST(ColumnSources, AFadedSideGoesFromNothingToAllInTheMiddleThird) {
  double before = 0.0;
  for (double front_m = 0.0; front_m <= 1.0; front_m += 1e-3) {
    const double share = share_behind(front_m, 1.0 - front_m, SecondSide::kFaded);
    EXPECT_NEAR(share, std::clamp(3.0 * front_m - 1.0, 0.0, 1.0), 1e-3) << front_m;
    EXPECT_NEAR(share, before, 4e-3) << front_m;
    before = share;
  }
}

// The shares of all stations of an endless line add up to the number that is mixed, wherever the
// line is met: one station is cross-faded to the next.
TEST(StationShare, IsAContinuousPartition) {
  for (const StationMix mix : {StationMix{1, 0.1}, {1, 0.5}, {2, 1.0}, {7, 0.5}, {16, 0.1}}) {
    for (double met = 0.0; met < 1.0; met += 0.01) {
      double sum = 0.0;
      for (int station = -10; station <= 11; ++station) {
        const float share = station_share(station - met, mix);
        sum += share;
        EXPECT_NEAR(share, station_share(station - met + 1e-4, mix), 1.1e-4 / mix.fade);
      }
      EXPECT_NEAR(sum, mix.stations, 1e-4) << " at " << met;
    }
  }
  EXPECT_EQ(station_share(0.2, {1, 0.5}), 1.0f);
}

TEST(StationWindow, HoldsTheStationsOfTheLineThatHaveAShare) {
  for (const int stations : {2, 3, 9, 40}) {
    for (const StationMix mix : {StationMix{1, 0.1}, {1, 1.0}, {2, 0.5}, {3, 0.2}, {16, 1.0}}) {
      for (int place = 0; place <= 10 * (stations - 1); ++place) {
        const int station = std::min(place / 10, stations - 2);
        const RaySource at{.station = station, .fraction = 0.1 * place - station};
        const StationWindow window = stations_mixed(at, stations, mix);
        ASSERT_GE(window.first, 0);
        ASSERT_LE(window.first, window.last) << "there is one at the end of a line";
        ASSERT_LT(window.last, stations);
        for (int i = 0; i < stations; ++i) {
          if (i >= window.first && i <= window.last) continue;
          ASSERT_LT(station_share(i - 0.1 * place, mix), 1e-5f)
              << i << " of " << stations << ", " << mix.stations << " around " << 0.1 * place;
        }
      }
    }
  }
}

// Linear within a surface, the nearest row's across a step and where a station's columns jump.
TEST(InterpolateRows, JoinsWhatIsOneSurface) {
  constexpr int kRows = 9;
  for (const int per_row : {1, 2, 3, 4, 8}) {
    const RowMap map(kRows * per_row, kRows);
    std::array<float, kRows + 2> at{}, joined{};
    for (std::size_t i = 0; i < at.size(); ++i) {
      at[i] = i < 7 ? 3.0f * static_cast<float>(i) : 500.0f;
      joined[i] = i == 4 ? 0.0f : 1.0f;  // a step between rows 3 and 4, a jump after row 5
    }
    std::array<float, 8 * kRows> out{}, general{};
    const RowsBetween rows{map.nearest.data(), map.down.data(), map.per_row(), kRows * per_row};
    interpolate_rows(at.data() + 1, joined.data() + 1, rows, 100.0f, out.data());
    interpolate_rows(at.data() + 1, joined.data() + 1, {rows.nearest, rows.down, 0, rows.rows},
                     100.0f, general.data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(rows.rows); ++i) {
      const auto row = static_cast<std::size_t>(map.nearest[i]) + 1;
      const double down = map.down[i];
      const bool apart = down < 0.0 ? row == 5 || row == 7 : row == 4 || row == 6;
      const double beside = down < 0.0 ? at[row - 1] : at[row + 1];
      const double truth = at[row] + (apart ? 0.0 : std::fabs(down) * (beside - at[row]));
      EXPECT_NEAR(general[i], truth, 1e-4) << i << " of " << rows.rows;
      EXPECT_NEAR(out[i], truth, 1e-4) << i << " of " << rows.rows;
    }
  }
}

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
