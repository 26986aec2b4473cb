#include "build_lf/depth/parallax_refinement.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "build_lf/depth/pixel_directions.h"
#include "core/base/parallel.h"
#include "core/geometry/fast_math.h"

namespace raywalk::build_lf {
namespace {

constexpr int kRefinements = 2;
constexpr int kWindow = 2;  // pixels to each side

// Sums of the normal equation, in levels and pixels of parallax at the reach.
struct NormalSums {
  float gradient_error = 0.0f;   // sum of w g e
  float gradient_square = 0.0f;  // sum of w g^2
  float weight = 0.0f;           // sum of w
};

// Mean of the colours of four samples around a direction, in levels; none where one of them is
// invalid.
std::optional<float> luminance_at(const StationPicture& picture, float x, float y, float z) {
  const int width = picture.size.width;
  const int height = picture.size.height;
  const float plan = std::sqrt(x * x + z * z);
  const float u = (fast_atan2(x, z) * kPerTurn + 0.5f) * static_cast<float>(width) - 0.5f;
  const float v =
      std::clamp((0.5f - fast_atan2(y, plan) * kPerHalfTurn) * static_cast<float>(height) - 0.5f,
                 0.0f, static_cast<float>(height - 1));
  const int left = static_cast<int>(u + 1.0f) - 1;  // floor: u is at least -1
  const int upper = std::min(static_cast<int>(v), height - 2);
  const float right_part = u - static_cast<float>(left);
  const float lower_part = v - static_cast<float>(upper);
  bool valid = true;
  const auto sum_of = [&](MatchingSample sample) {
    valid = valid && is_valid(sample);
    return static_cast<float>(colour_sum(sample));
  };
  const auto column = [&](int theta) {
    const MatchingSample* samples = picture.samples.data() +
                                    static_cast<size_t>(theta) * static_cast<size_t>(height) +
                                    static_cast<size_t>(upper);
    const float above = sum_of(samples[0]);
    return above + lower_part * (sum_of(samples[1]) - above);
  };
  const float first = column(left < 0 ? left + width : left);
  const float second = column(left + 1 < width ? left + 1 : 0);
  if (!valid) return std::nullopt;
  return (first + right_part * (second - first)) / 3.0f;
}

class Refiner {
 public:
  Refiner(const TileViews& views, double reach_m, InverseDistanceMap* map)
      : views_(views),
        map_(map),
        pixel_per_m_(static_cast<float>(kTwoPi / map->size.width / reach_m)),
        sums_(map->omega.size()) {}

  void step() {
    parallel_for(0, views_.tiles(), 4, [&](int begin, int end) {
      for (int tile = begin; tile < end; ++tile) sum_tile(tile);
    });
    const std::vector<float> before = map_->omega;
    parallel_for(0, map_->size.width, 8, [&](int begin, int end) {
      for (int theta = begin; theta < end; ++theta) {
        for (int phi = 0; phi < map_->size.height; ++phi) move_pixel(before, theta, phi);
      }
    });
  }

 private:
  void sum_tile(int tile) {
    const ReferenceTile reference = reference_tile(views_, tile);
    size_t i = 0;
    for (int column = 0; column < views_.columns(tile); ++column) {
      for (int row = 0; row < views_.rows(tile); ++row, ++i) {
        const size_t pixel = pixel_index(views_.first_column(tile) + column,
                                         views_.first_row(tile) + row, map_->size);
        const MatchingSample sample = reference.samples[i];
        if (!is_valid(sample)) {
          sums_[pixel] = NormalSums{};
          continue;
        }
        const float luminance = static_cast<float>(colour_sum(sample)) / 3.0f;
        sums_[pixel] =
            sums_of(views_.of_tile(tile), {reference.x[i], reference.y[i], reference.z[i]},
                    luminance, map_->omega[pixel]);
      }
    }
  }

  NormalSums sums_of(const MatchingViews& views, const Eigen::Vector3f& direction, float luminance,
                     float omega) const {
    // Differences of twelve levels are as likely to be another surface as the same one.
    constexpr float kOutlierLevels = 12.0f;
    const float half = 0.5f * pixel_per_m_;
    NormalSums sums;
    for (const auto& side : views.side) {
      for (const int i : side) {
        const TileView& view = views_.view(i);
        const Eigen::Vector3f offset = view.to_reference_m.cast<float>();
        const auto shown = [&](float at_omega) {
          return luminance_at(*view.picture, direction.x() + at_omega * offset.x(),
                              direction.y() + at_omega * offset.y(),
                              direction.z() + at_omega * offset.z());
        };
        const std::optional<float> nearer = shown(omega + half);
        if (!nearer) continue;
        const std::optional<float> farther = shown(omega - half);
        if (!farther) continue;
        const float gradient = *nearer - *farther;
        const float error = luminance - 0.5f * (*nearer + *farther);
        const float weight = 1.0f / (1.0f + error * error / (kOutlierLevels * kOutlierLevels));
        sums.gradient_error += weight * gradient * error;
        sums.gradient_square += weight * gradient * gradient;
        sums.weight += weight;
      }
    }
    return sums;
  }

  void move_pixel(const std::vector<float>& before, int theta, int phi) {
    // A gradient of two levels per pixel is indistinguishable from noise.
    constexpr float kNoiseGradient = 2.0f;
    constexpr float kMaxPx = 0.5f;
    const size_t pixel = pixel_index(theta, phi, map_->size);
    NormalSums sums;
    for (int du = -kWindow; du <= kWindow; ++du) {
      const int column = (theta + du + map_->size.width) % map_->size.width;
      for (int row = std::max(0, phi - kWindow);
           row <= std::min(map_->size.height - 1, phi + kWindow); ++row) {
        const size_t other = pixel_index(column, row, map_->size);
        if (std::fabs(before[other] - before[pixel]) > pixel_per_m_) continue;
        sums.gradient_error += sums_[other].gradient_error;
        sums.gradient_square += sums_[other].gradient_square;
        sums.weight += sums_[other].weight;
      }
    }
    const float damped = sums.gradient_square + kNoiseGradient * kNoiseGradient * sums.weight;
    if (damped <= 0.0f) return;
    const float step_px = std::clamp(sums.gradient_error / damped, -kMaxPx, kMaxPx);
    map_->omega[pixel] = std::max(0.0f, before[pixel] + step_px * pixel_per_m_);
  }

  const TileViews& views_;
  InverseDistanceMap* map_;
  float pixel_per_m_;  // inverse distance with one pixel of parallax at the reach, 1/m
  std::vector<NormalSums> sums_;
};

}  // namespace

void refine_parallax(const TileViews& views, double reach_m, InverseDistanceMap* map) {
  Refiner refiner(views, reach_m, map);
  for (int i = 0; i < kRefinements; ++i) refiner.step();
}

}  // namespace raywalk::build_lf
