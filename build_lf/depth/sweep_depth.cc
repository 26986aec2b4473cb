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

// The largest inverse distance that is looked for.
double sweep_limit_per_m(const DepthPlan& plan) { return 1.0 / (kNearestPerReach * plan.reach_m); }

}  // namespace

void OmegaHistogram::add(const InverseDistanceMap& map) {
  constexpr int kConfident = 64;
  const auto rows = static_cast<size_t>(map.size.height);
  std::vector<std::int64_t> weights(rows);
  for (size_t row = 0; row < rows; ++row) {
    const double phi_rad = angles_from_pixel({0.0, static_cast<double>(row)}, map.size).phi_rad;
    weights[row] = std::llround(kFullWeight * std::cos(phi_rad));
  }
  for (size_t p = 0; p < map.omega.size(); ++p) {
    if (map.confidence[p] < kConfident) continue;
    const double bin = std::clamp(map.omega[p] / limit_per_m_ * kBins, 0.0, kBins - 1.0);
    share_[static_cast<size_t>(bin)] += weights[p % rows];
    total_ += weights[p % rows];
  }
}

double OmegaHistogram::exceeded_by(double share) const {
  int bin = kBins - 1;
  for (std::int64_t nearer = 0; bin > 0; --bin) {
    nearer += share_[static_cast<size_t>(bin)];
    if (static_cast<double>(nearer) > share * static_cast<double>(total_)) break;
  }
  return limit_per_m_ * (bin + 1) / kBins;
}

PanoramaSize coarse_size(const DepthPlan& plan) {
  constexpr int kReduction = 4;
  return {plan.size.width / kReduction, plan.size.height / kReduction};
}

double near_distance_m(const DepthPlan& plan, const OmegaHistogram& histogram) {
  constexpr double kNear = 0.25;
  const double step_per_m =
      sweep_layers(sweep_limit_per_m(plan), plan.reach_m, coarse_size(plan)).step_per_m;
  const double near_per_m = histogram.exceeded_by(kNear);
  if (histogram.empty() || near_per_m < 2.0 * step_per_m) {
    return std::numeric_limits<double>::infinity();
  }
  return 1.0 / near_per_m;
}

OmegaHistogram sweep_coarse_maps(const Room& room, const DepthPlan& plan, const cv::Mat& valid,
                                 const char* stage, PartialMaps* partial) {
  const GainFields gains = unit_gain_fields(room.grid());
  StationSweep sweep(room, plan, coarse_size(plan), sweep_limit_per_m(plan), gains, valid, true,
                     partial->directory());
  make_maps(plan, {0, plan.maps.size()}, stage, "looking for the nearest surfaces", partial,
            [&](int i) { return sweep.map_at(plan.maps[static_cast<size_t>(i)]); });
  OmegaHistogram histogram(sweep_limit_per_m(plan));
  for (const SweepReference& map : plan.maps) histogram.add(partial->stored(stage, map.station));
  return histogram;
}

double nearest_surfaces_per_m(const DepthPlan& plan, const OmegaHistogram& histogram) {
  // The share of the pixels that may lie nearer than the sweep's near limit: false matches are
  // spread over all layers.
  constexpr double kNearer = 0.001;
  constexpr double kMargin = 1.25;
  return std::min(sweep_limit_per_m(plan), kMargin * histogram.exceeded_by(kNearer));
}

void sweep_maps(const Room& room, const DepthPlan& plan, double max_per_m, const GainFields& gains,
                const cv::Mat& valid, IndexRange share, PartialMaps* partial) {
  StationSweep sweep(room, plan, plan.size, max_per_m, gains, valid, false, partial->directory());
  make_maps(plan, share, kSweptStage, "sweeping", partial,
            [&](int i) { return sweep.map_at(plan.maps[static_cast<size_t>(i)]); });
}

}  // namespace raywalk::build_lf
