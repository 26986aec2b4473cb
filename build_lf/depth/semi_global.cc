#include "build_lf/depth/semi_global.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "build_lf/depth/matching_kernels.h"
#include "build_lf/depth/sphere_walks.h"
#include "core/base/parallel.h"

namespace raywalk::build_lf {
namespace {

// The penalties P1 for a change of one layer and P2 for larger ones, in units of CostVolume::cost.
// The maximum cost is 176, so one clear difference outweighs a jump. Across an edge of g levels P2
// is divided by 1 + g / 5, as distances jump where colours do.
constexpr int kSmallStep = 12;
constexpr int kLargeStep = 96;
constexpr double kEdgeLevels = 5.0;

class PathCosts {
 public:
  PathCosts(const CostVolume& volume, std::pmr::vector<std::uint16_t>* sum)
      : volume_(volume), sum_(sum->data()), layers_(static_cast<size_t>(volume.layers.count)) {
    for (int g = 0; g < 256; ++g) {
      large_step_.push_back(static_cast<std::uint16_t>(
          std::max<double>(kSmallStep + 1, kLargeStep / (1.0 + g / kEdgeLevels))));
    }
  }

  // Adds the path costs along a walk of `steps` pixels, after a run-up of `run_up` pixels that are
  // not added.
  void add(Walk walk, int run_up, int steps) const {
    // One layer more at either end, too expensive to be chosen.
    constexpr std::uint16_t kTooExpensive = 30000;
    std::vector<std::uint16_t> previous(layers_ + 2, kTooExpensive);
    std::vector<std::uint16_t> path(layers_ + 2, kTooExpensive);
    std::vector<std::uint16_t> dropped(layers_);
    std::fill(previous.begin() + 1, previous.end() - 1, std::uint16_t{0});
    std::uint16_t least = 0;
    int last_luminance = -1;
    for (int i = -run_up; i < steps; ++i) {
      const size_t pixel = pixel_index(walk.theta, walk.phi, volume_.size);
      const int luminance = volume_.luminance[pixel];
      const int edge = last_luminance < 0 ? 0 : std::abs(luminance - last_luminance);
      std::uint16_t* sum = i < 0 ? dropped.data() : sum_ + pixel * layers_;
      least = kernels_.extend_path(volume_.cost.data() + pixel * layers_, previous.data() + 1,
                                   least, kSmallStep, large_step_[static_cast<size_t>(edge)],
                                   volume_.layers.count, path.data() + 1, sum);
      std::swap(previous, path);
      last_luminance = luminance;
      walk.advance(volume_.size);
    }
  }

 private:
  const MatchingKernels& kernels_ = matching_kernels();
  const CostVolume& volume_;
  std::uint16_t* sum_;
  size_t layers_;
  std::vector<std::uint16_t> large_step_;
};

// The best layer of a pixel with subpixel interpolation, and its confidence.
struct LayerChoice {
  double layer = 0.0;
  std::uint8_t confidence = 0;
};

LayerChoice choose_layer(const std::uint16_t* sum, int layers) {
  const int best = static_cast<int>(std::min_element(sum, sum + layers) - sum);
  LayerChoice choice{static_cast<double>(best), 0};
  if (best > 0 && best < layers - 1) {
    const double left = sum[best - 1];
    const double right = sum[best + 1];
    const double bend = left - 2.0 * sum[best] + right;
    if (bend > 0.0) choice.layer += 0.5 * (left - right) / bend;
  }
  constexpr int kSameMinimum = 2;
  int elsewhere = 65535;
  for (int k = 0; k < layers; ++k) {
    if (std::abs(k - best) > kSameMinimum) elsewhere = std::min<int>(elsewhere, sum[k]);
  }
  // A margin of about seven levels of each colour along every path gives full confidence.
  constexpr double kFullConfidence = kPaths * 40.0;
  choice.confidence = static_cast<std::uint8_t>(
      std::clamp((elsewhere - sum[best]) / kFullConfidence * 255.0, 1.0, 255.0));
  return choice;
}

}  // namespace

InverseDistanceMap regularise(const CostVolume& volume, const SweepReference& reference,
                              SemiGlobalScratch* scratch) {
  scratch->sum.assign(volume.cost.size(), 0);
  const PathCosts paths(volume, &scratch->sum);
  for_each_walk(volume.size,
                [&](Walk walk, int run_up, int steps) { paths.add(walk, run_up, steps); });
  InverseDistanceMap map{reference.station, reference.position_m, volume.size, {}, {}};
  map.inverse.resize(volume.luminance.size());
  map.confidence.resize(volume.luminance.size());
  const auto layers = static_cast<size_t>(volume.layers.count);
  parallel_for(0, volume.size.width, 8, [&](int begin, int end) {
    const auto rows = static_cast<size_t>(volume.size.height);
    for (size_t p = static_cast<size_t>(begin) * rows; p < static_cast<size_t>(end) * rows; ++p) {
      const LayerChoice choice =
          choose_layer(scratch->sum.data() + p * layers, volume.layers.count);
      map.inverse[p] = static_cast<float>(choice.layer * volume.layers.step_per_m);
      map.confidence[p] = volume.valid[p] != 0 ? choice.confidence : std::uint8_t{0};
    }
  });
  return map;
}

}  // namespace raywalk::build_lf
