#include "build_lf/depth/plane_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/base/parallel.h"

namespace raywalk::build_lf {
namespace {

// As MatchingKernels::average_views, but over valid samples only: a masked view of a surface is no
// evidence against it. A pixel with a single valid sample gets one maximum difference in addition.
void average_valid_views(const std::array<ViewDifferences, kMaxViews>& differences, int views,
                         int count, float* mean) {
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    std::array<std::int32_t, kMaxViews> valid{};
    size_t known = 0;
    for (size_t v = 0; v < static_cast<size_t>(views); ++v) {
      if (differences[v][i] != kInvalidDifference) valid[known++] = differences[v][i];
    }
    for (; known < 2; ++known) valid[known] = kMaxDifference;
    const size_t kept = std::max<size_t>(2, (known + 1) / 2);
    const auto end = valid.begin() + static_cast<std::ptrdiff_t>(kept);
    std::partial_sort(valid.begin(), end, valid.begin() + static_cast<std::ptrdiff_t>(known));
    const auto mean_to = [&](size_t compared) {
      const auto last = valid.begin() + static_cast<std::ptrdiff_t>(compared);
      return static_cast<float>(std::accumulate(valid.begin(), last, 0)) /
             static_cast<float>(compared);
    };
    mean[i] = (1.0f - kShareOfAllViews) * mean_to(kept) + kShareOfAllViews * mean_to(known);
  }
}

// Sweeps one reference tile by tile: from one layer to the next a tile's pixels move little, so
// their samples are still in cache.
class Sweeper {
 public:
  Sweeper(const TileViews& views, CostVolume* volume) : views_(views), volume_(volume) {}

  void sweep_tile(int tile) const {
    const MatchingViews& views = views_.of_tile(tile);
    const ReferenceTile reference = reference_tile(views_, tile);
    const bool compared = !views.side[0].empty() || !views.side[1].empty();
    const std::vector<std::uint8_t> costs =
        compared ? costs_of(views, reference) : std::vector<std::uint8_t>();
    size_t i = 0;
    for (int column = 0; column < views_.columns(tile); ++column) {
      for (int row = 0; row < views_.rows(tile); ++row, ++i) {
        const size_t pixel = pixel_index(views_.first_column(tile) + column,
                                         views_.first_row(tile) + row, volume_->size);
        store(pixel, i, reference, costs);
      }
    }
  }

 private:
  // [layer][pixel of the tile]
  std::vector<std::uint8_t> costs_of(const MatchingViews& views,
                                     const ReferenceTile& reference) const {
    const auto layers = static_cast<size_t>(volume_->layers.count);
    const auto count = static_cast<size_t>(reference.count);
    std::vector<std::uint8_t> costs(layers * count);
    std::array<ViewDifferences, kMaxViews> differences;
    std::array<float, kTilePixels> mean;
    for (size_t k = 0; k < layers; ++k) {
      const double inverse = static_cast<double>(k) * volume_->layers.step_per_m;
      const int compared = compare_with(views, inverse, reference, &differences);
      if (some_invalid(differences, compared, reference.count)) {
        average_valid_views(differences, compared, reference.count, mean.data());
      } else {
        kernels_.average_views(differences, compared, reference.count, mean.data());
      }
      constexpr float kCostPerDifference = 2.0f / 3.0f;
      for (size_t i = 0; i < count; ++i) {
        costs[k * count + i] = static_cast<std::uint8_t>(mean[i] * kCostPerDifference);
      }
    }
    return costs;
  }

  // Stores pixel i of the tile; without costs, or where the reference is invalid, as not
  // comparable.
  void store(size_t pixel, size_t i, const ReferenceTile& reference,
             const std::vector<std::uint8_t>& costs) const {
    const MatchingSample sample = reference.samples[i];
    const bool usable = !costs.empty() && is_valid(sample);
    volume_->valid[pixel] = usable ? 1 : 0;
    volume_->luminance[pixel] = static_cast<std::uint8_t>(colour_sum(sample) / 3);
    const auto layers = static_cast<size_t>(volume_->layers.count);
    std::uint8_t* cost = &volume_->cost[pixel * layers];
    for (size_t k = 0; k < layers; ++k) {
      cost[k] = usable ? costs[k * static_cast<size_t>(reference.count) + i] : std::uint8_t{0};
    }
  }

  // Computes the differences of every station on either side; returns their number.
  int compare_with(const MatchingViews& views, double inverse, const ReferenceTile& reference,
                   std::array<ViewDifferences, kMaxViews>* differences) const {
    static_assert(kMaxViews == 2 * kViewsPerSide);
    size_t compared = 0;
    for (const auto& side : views.side) {
      for (const int i : side) {
        const TileView& view = views_.view(i);
        const Eigen::Vector3f offset = (inverse * view.to_reference_m).cast<float>();
        kernels_.compare(reference.rays(),
                         {view.picture->samples.data(), view.picture->size.width,
                          view.picture->size.height, offset.x(), offset.y(), offset.z()},
                         (*differences)[compared++].data());
      }
    }
    return static_cast<int>(compared);
  }

  bool some_invalid(const std::array<ViewDifferences, kMaxViews>& differences, int compared,
                    int count) const {
    if (views_.all_valid()) return false;
    return std::any_of(differences.begin(), differences.begin() + compared,
                       [&](const ViewDifferences& view) {
                         const auto end = view.begin() + count;
                         return std::find(view.begin(), end, kInvalidDifference) != end;
                       });
  }

  const MatchingKernels& kernels_ = matching_kernels();
  const TileViews& views_;
  CostVolume* volume_;
};

}  // namespace

SweepLayers sweep_layers(double max_per_m, double reach_m, PanoramaSize size) {
  constexpr int kMultiple = 16;
  constexpr double kStepPx = 1.5;
  const double step_rad = kStepPx * kTwoPi / size.width;
  const double wanted = max_per_m * reach_m / step_rad + 1.0;
  const int count =
      std::max(kMultiple, static_cast<int>(std::ceil(wanted / kMultiple)) * kMultiple);
  return {count, max_per_m / (count - 1)};
}

void sweep(const TileViews& views, const SweepLayers& layers, CostVolume* volume) {
  volume->size = views.map_size();
  volume->layers = layers;
  const size_t pixels =
      static_cast<size_t>(volume->size.width) * static_cast<size_t>(volume->size.height);
  volume->cost.resize(pixels * static_cast<size_t>(layers.count));
  volume->luminance.resize(pixels);
  volume->valid.resize(pixels);
  const Sweeper sweeper(views, volume);
  parallel_for(0, views.tiles(), 4, [&](int begin, int end) {
    for (int tile = begin; tile < end; ++tile) sweeper.sweep_tile(tile);
  });
}

}  // namespace raywalk::build_lf
