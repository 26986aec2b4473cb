#include "build_lf/depth/sweep_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "build_lf/depth/map_completion.h"
#include "build_lf/depth/map_fusion.h"
#include "build_lf/depth/parallax_refinement.h"
#include "build_lf/depth/semi_global.h"
#include "build_lf/depth/station_colours.h"
#include "build_lf/depth/station_image.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace raywalk::build_lf {
namespace {

// Cache size: neighbouring references share most pictures.
constexpr std::size_t kPicturesKept = 48;

constexpr const char* kSweptStage = "swept";

struct SweepRun {
  const char* progress;
  const char* stage;
  double max_per_m;
  bool refine;
};

InverseDistanceMap sweep_station(const DepthPlan& plan, const SweepReference& reference,
                                 const SweepLayers& layers, PictureCache* pictures,
                                 CostVolume* volume, SemiGlobalScratch* scratch, bool refine) {
  const TileViews views(reference, candidates_near(plan, reference), plan.reach_m, pictures);
  sweep(views, layers, volume);
  InverseDistanceMap map = regularise(*volume, reference, scratch);
  if (refine) refine_parallax(views, plan.reach_m, &map);
  return map;
}

// Sweeps the stations without a stored map of the stage. `see` is called with every map, in order.
template <typename See>
void sweep_all(const DepthPlan& plan, const SweepRun& run, PictureCache* pictures,
               PartialMaps* partial, const See& see) {
  const SweepLayers layers = sweep_layers(run.max_per_m, plan.reach_m, pictures->map_size());
  CostVolume volume;
  SemiGlobalScratch scratch;
  Progress progress(run.progress, static_cast<std::int64_t>(plan.maps.size()), "stations");
  for (const SweepReference& reference : plan.maps) {
    throw_if_interrupted();
    auto map =
        partial->load(run.stage, reference.station, reference.position_m, pictures->map_size());
    if (!map) {
      map = sweep_station(plan, reference, layers, pictures, &volume, &scratch, run.refine);
      partial->store(run.stage, *map);
    }
    see(*map);
    progress.advance();
  }
}

// Inverse distances from 0 to a limit by solid angle.
class OmegaHistogram {
 public:
  explicit OmegaHistogram(double limit_per_m) : limit_per_m_(limit_per_m) {}

  // Counts the confident pixels of a map.
  void add(const InverseDistanceMap& map) {
    constexpr int kConfident = 64;
    const auto rows = static_cast<size_t>(map.size.height);
    for (size_t p = 0; p < map.omega.size(); ++p) {
      if (map.confidence[p] < kConfident) continue;
      const double phi_rad = angles_from_pixel({0.0, double(p % rows)}, map.size).phi_rad;
      const double bin = std::clamp(map.omega[p] / limit_per_m_ * kBins, 0.0, kBins - 1.0);
      share_[static_cast<size_t>(bin)] += std::cos(phi_rad);
      total_ += std::cos(phi_rad);
    }
  }
  // The largest inverse distance of the bin above which less than `share` of the solid angle lies.
  double exceeded_by(double share) const {
    int bin = kBins - 1;
    for (double nearer = 0.0; bin > 0; --bin) {
      nearer += share_[static_cast<size_t>(bin)];
      if (nearer > share * total_) break;
    }
    return limit_per_m_ * (bin + 1) / kBins;
  }
  bool empty() const { return total_ <= 0.0; }

 private:
  static constexpr int kBins = 1024;
  double limit_per_m_;
  std::array<double, kBins> share_{};
  double total_ = 0.0;
};

// The colours of the stations that vote on a map. Neighbouring maps share most of their voters.
class VoterColours {
 public:
  VoterColours(const Room& room, const DepthPlan& plan,
               const std::vector<std::vector<GainField>>& gains)
      : room_(room), plan_(plan), gains_(gains) {}

  // The ranges of plan.maps[voter] for each voter. Those of other stations are dropped.
  std::vector<cv::Mat> of(std::span<const int> voters) {
    std::vector<cv::Mat> ranges(voters.size());
    parallel_for(0, static_cast<int>(voters.size()), 1, [&](int begin, int end) {
      for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
        const auto known = kept_.find(voters[i]);
        ranges[i] = known != kept_.end() ? known->second : read(voters[i]);
      }
    });
    kept_.clear();
    for (size_t i = 0; i < voters.size(); ++i) kept_.emplace(voters[i], ranges[i]);
    return ranges;
  }

 private:
  cv::Mat read(int voter) const {
    const StationIndex station = plan_.maps[static_cast<size_t>(voter)].station;
    const auto& gains =
        gains_[static_cast<size_t>(station.line)][static_cast<size_t>(station.station)];
    return ranges_of(station_colours(room_, station, plan_.size, gains));
  }

  const Room& room_;
  const DepthPlan& plan_;
  const std::vector<std::vector<GainField>>& gains_;
  std::map<int, cv::Mat> kept_;
};

// The nearest distance looked for, as a share of the reach.
constexpr double kNearestPerReach = 0.25;

}  // namespace

PanoramaSize coarse_size(const DepthPlan& plan) {
  constexpr int kReduction = 4;
  return {plan.size.width / kReduction, plan.size.height / kReduction};
}

double near_distance_m(const Room& room, const DepthPlan& plan,
                       const std::vector<std::vector<GainField>>& gains, const cv::Mat& valid) {
  const PanoramaSize size = coarse_size(plan);
  const double limit = 1.0 / (kNearestPerReach * plan.reach_m);
  const SweepLayers layers = sweep_layers(limit, plan.reach_m, size);
  OmegaHistogram histogram(limit);
  PictureCache pictures(room, size, gains, valid, kPicturesKept, true);
  CostVolume volume;
  SemiGlobalScratch scratch;
  for (const SweepReference& reference : plan.maps) {
    throw_if_interrupted();
    histogram.add(sweep_station(plan, reference, layers, &pictures, &volume, &scratch, false));
  }
  constexpr double kNear = 0.25;
  const double near_per_m = histogram.exceeded_by(kNear);
  if (histogram.empty() || near_per_m < 2.0 * layers.step_per_m) {
    return std::numeric_limits<double>::infinity();
  }
  return 1.0 / near_per_m;
}

double find_nearest_surfaces(const Room& room, const DepthPlan& plan,
                             const std::vector<std::vector<GainField>>& gains, const cv::Mat& valid,
                             PartialMaps* partial) {
  // The share of the pixels that may lie nearer than the sweep's near limit: false matches are
  // spread over all layers.
  constexpr double kNearer = 0.001;
  constexpr double kMargin = 1.25;
  const double limit = 1.0 / (kNearestPerReach * plan.reach_m);
  OmegaHistogram histogram(limit);
  PictureCache pictures(room, coarse_size(plan), gains, valid, kPicturesKept, true);
  sweep_all(plan, {"looking for the nearest surfaces", kCoarseStage, limit, false}, &pictures,
            partial, [&](const InverseDistanceMap& map) { histogram.add(map); });
  return std::min(limit, kMargin * histogram.exceeded_by(kNearer));
}

void sweep_maps(const Room& room, const DepthPlan& plan, double max_per_m,
                const std::vector<std::vector<GainField>>& gains, const cv::Mat& valid,
                PartialMaps* partial) {
  PictureCache pictures(room, plan.size, gains, valid, kPicturesKept);
  sweep_all(plan, {"sweeping", kSweptStage, max_per_m, true}, &pictures, partial,
            [](const InverseDistanceMap&) {});
}

void fuse_swept_maps(const Room& room, const DepthPlan& plan,
                     const std::vector<std::vector<GainField>>& gains, PartialMaps* partial) {
  // 1.5 pixels of parallax at the reach: both maps are off by up to half a layer, and their pixels
  // do not coincide.
  constexpr double kAgreePx = 1.5;
  // With six voters, two maps that agree are enough for kMinConfidence.
  constexpr int kMinVoters = 6;
  FusionOptions options{.tolerance_per_m = kAgreePx / plan.pixels_per_omega_m()};
  const bool masked = room.masked();
  if (masked) options.min_voters = kMinVoters;
  const int count = static_cast<int>(plan.maps.size());
  VoterColours colours(room, plan, gains);
  Progress progress("fusing", count, "maps");
  for (int i = 0; i < count; ++i) {
    throw_if_interrupted();
    const SweepReference& own = plan.maps[static_cast<size_t>(i)];
    if (!partial->load(kFinalStage, own.station, own.position_m, plan.size)) {
      std::vector<InverseDistanceMap> maps;
      std::vector<int> voters = voters_of(plan, i);
      if (masked) {
        const std::vector<int> farther = fallback_voters_of(plan, voters);
        voters.insert(voters.end(), farther.begin(), farther.end());
        options.fallback_maps = static_cast<int>(farther.size());
      }
      for (const int voter : voters) {
        const SweepReference& reference = plan.maps[static_cast<size_t>(voter)];
        maps.push_back(
            partial->load_stored(kSweptStage, reference.station, reference.position_m, plan.size));
      }
      InverseDistanceMap map = fuse_maps(maps, 0, options, colours.of(voters));
      partial->store(kVotedStage, map);
      complete_map(station_image(room, own.station, plan.size),
                   station_validity(room, own.station, plan.size, 0), options.tolerance_per_m,
                   &map);
      partial->store(kFinalStage, map);
    }
    progress.advance();
  }
}

}  // namespace raywalk::build_lf
