#include "build_lf/depth/sweep_depth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory_resource>
#include <span>

#include "build_lf/depth/file_memory.h"
#include "build_lf/depth/semi_global.h"
#include "core/base/usable_memory.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {
namespace {

// A pixel at the horizon; small enough for 10^11 pixels.
constexpr double kFullWeight = 1 << 24;

// Cache size: neighbouring references share most pictures.
constexpr std::size_t kPicturesKept = 48;

// Sweeps one station after another. Costs and pictures lie in memory while half of what may be used
// holds them (the rest is for the panoramas, which are mapped), otherwise all of them in files: a
// small machine or control group makes a sweep slower and does not end it. All, as the pictures are
// read while only one of the costs' two arrays is in use: the kernel then writes the other one out.
class StationSweep {
 public:
  StationSweep(const Room& room, const DepthPlan& plan, PanoramaSize size, double max_per_m,
               const GainFields& gains, const cv::Mat& valid, bool levelled,
               const std::filesystem::path& scratch)
      : plan_(plan),
        layers_(sweep_layers(max_per_m, plan.reach_m, size)),
        files_(scratch),
        volume_{size, layers_, std::pmr::vector<std::uint8_t>(memory_for(size)), {}, {}},
        scratch_{std::pmr::vector<std::uint16_t>(memory_for(size))},
        pictures_(kPicturesKept, [&room, size, &gains, valid, levelled,
                                  memory = memory_for(size)](StationIndex station) {
          return make_station_picture(room, station, size, gain_field(gains, station), valid,
                                      levelled, memory);
        }) {}

  InverseDistanceMap map_at(const SweepReference& reference) {
    const TileViews views(reference, candidates_near(plan_, reference), plan_.reach_m, volume_.size,
                          &pictures_);
    sweep(views, layers_, &volume_);
    return regularise(volume_, reference, &scratch_);
  }

 private:
  static std::uint64_t pixels(PanoramaSize size) {
    return static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
  }
  std::uint64_t cost_bytes(PanoramaSize size) const {
    return pixels(size) * static_cast<std::uint64_t>(layers_.count) *
           (sizeof(std::uint8_t) + sizeof(std::uint16_t));
  }
  static std::uint64_t picture_bytes(PanoramaSize size) {
    return pixels(size) * kPicturesKept * kSamplesPerPixel * kSamplesPerPixel *
           sizeof(MatchingSample);
  }
  std::pmr::memory_resource* memory_for(PanoramaSize size) {
    const bool fits = cost_bytes(size) + picture_bytes(size) <= usable_memory_bytes() / 2;
    return fits ? std::pmr::get_default_resource() : &files_;
  }

  const DepthPlan& plan_;
  SweepLayers layers_;
  FileMemory files_;
  CostVolume volume_;
  SemiGlobalScratch scratch_;
  PictureCache pictures_;
};

// The nearest distance looked for, as a share of the reach.
constexpr double kNearestPerReach = 0.25;

// How much of the sphere shows surfaces at which inverse distance, from 0 to a limit, over many
// maps. The weights are whole numbers, so that their sum is exact.
class InverseHistogram {
 public:
  explicit InverseHistogram(double limit_per_m) : limit_per_m_(limit_per_m), share_(kBins) {}

  // Counts the confident pixels of a map.
  void add(const InverseDistanceMap& map) {
    constexpr int kConfident = 64;
    const auto rows = static_cast<size_t>(map.size.height);
    std::vector<std::int64_t> weights(rows);
    for (size_t row = 0; row < rows; ++row) {
      const double phi_rad = angles_from_pixel({0.0, static_cast<double>(row)}, map.size).phi_rad;
      weights[row] = std::llround(kFullWeight * std::cos(phi_rad));
    }
    for (size_t p = 0; p < map.inverse.size(); ++p) {
      if (map.confidence[p] < kConfident) continue;
      const double bin = std::clamp(map.inverse[p] / limit_per_m_ * kBins, 0.0, kBins - 1.0);
      share_[static_cast<size_t>(bin)] += weights[p % rows];
      total_ += weights[p % rows];
    }
  }
  // The largest inverse distance of the bin above which less than `share` of the solid angle lies.
  double exceeded_by(double share) const {
    int bin = kBins - 1;
    for (std::int64_t nearer = 0; bin > 0; --bin) {
      nearer += share_[static_cast<size_t>(bin)];
      if (static_cast<double>(nearer) > share * static_cast<double>(total_)) break;
    }
    return limit_per_m_ * (bin + 1) / kBins;
  }
  bool empty() const { return total_ == 0; }

 private:
  static constexpr int kBins = 1024;
  double limit_per_m_;
  std::vector<std::int64_t> share_;
  std::int64_t total_ = 0;
};

}  // namespace

PanoramaSize coarse_size(const DepthPlan& plan) {
  constexpr int kReduction = 4;
  // Narrower ones have too few pixels in a patch whose exposure is measured (patch_ratios.h).
  constexpr int kNarrowest = 128;
  const int width = std::max(plan.size.width / kReduction, std::min(plan.size.width, kNarrowest));
  return {width, width / 2};
}

NearSurfaces sweep_coarse_maps(const Room& room, const DepthPlan& plan, const cv::Mat& valid,
                               const char* stage, PartialMaps* partial) {
  constexpr double kNear = 0.25;
  // The share of the pixels that may lie nearer than the sweep's near limit: false matches are
  // spread over all layers.
  constexpr double kNearer = 0.001;
  constexpr double kMargin = 1.25;
  const double limit_per_m = 1.0 / (kNearestPerReach * plan.reach_m);
  const GainFields gains = unit_gain_fields(room.grid());
  StationSweep sweep(room, plan, coarse_size(plan), limit_per_m, gains, valid, true,
                     partial->directory());
  make_maps(plan, {0, plan.maps.size()}, stage, "looking for the nearest surfaces", partial,
            [&](int i) { return sweep.map_at(plan.maps[static_cast<size_t>(i)]); });
  InverseHistogram histogram(limit_per_m);
  for (const SweepReference& map : plan.maps) histogram.add(partial->stored(stage, map.station));
  NearSurfaces found{.nearest_per_m =
                         std::min(limit_per_m, kMargin * histogram.exceeded_by(kNearer))};
  const double near_per_m = histogram.exceeded_by(kNear);
  const double step_per_m = sweep_layers(limit_per_m, plan.reach_m, coarse_size(plan)).step_per_m;
  if (!histogram.empty() && near_per_m >= 2.0 * step_per_m) found.near_m = 1.0 / near_per_m;
  return found;
}

void sweep_maps(const Room& room, const DepthPlan& plan, double max_per_m, const GainFields& gains,
                const cv::Mat& valid, IndexRange share, PartialMaps* partial) {
  StationSweep sweep(room, plan, plan.size, max_per_m, gains, valid, false, partial->directory());
  make_maps(plan, share, kSweptStage, "sweeping", partial,
            [&](int i) { return sweep.map_at(plan.maps[static_cast<size_t>(i)]); });
}

}  // namespace raywalk::build_lf
