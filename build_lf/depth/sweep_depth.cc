#include "build_lf/depth/sweep_depth.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <memory_resource>
#include <span>

#include "build_lf/depth/map_completion.h"
#include "build_lf/depth/map_fusion.h"
#include "build_lf/depth/parallax_refinement.h"
#include "build_lf/depth/semi_global.h"
#include "build_lf/depth/station_colours.h"
#include "build_lf/depth/station_image.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/base/usable_memory.h"
#include "core/files/file_memory.h"

namespace raywalk::build_lf {
namespace {

// Cache size: neighbouring references share most pictures.
constexpr std::size_t kPicturesKept = 48;

std::span<const SweepReference> maps_of(const DepthPlan& plan, IndexRange share) {
  return std::span(plan.maps).subspan(share.begin, share.size());
}

struct SweepRun {
  const char* progress;
  const char* stage;
  bool refine;
};

// Sweeps one station after another. Costs and pictures lie in memory while half of what may be used
// holds them (the rest is for the panoramas, which are mapped), otherwise all of them in files: a
// small machine or control group makes a sweep slower and does not end it. All, as the pictures are
// read while only one of the costs' two arrays is in use: the kernel then writes the other one out.
class StationSweep {
 public:
  StationSweep(const Room& room, const DepthPlan& plan, PanoramaSize size, double max_per_m,
               const std::vector<std::vector<GainField>>& gains, const cv::Mat& valid,
               bool levelled, const std::filesystem::path& scratch)
      : plan_(plan),
        layers_(sweep_layers(max_per_m, plan.reach_m, size)),
        files_(scratch),
        volume_{size, layers_, std::pmr::vector<std::uint8_t>(memory_for(size)), {}, {}},
        scratch_{std::pmr::vector<std::uint16_t>(memory_for(size))},
        pictures_(room, size, gains, valid, kPicturesKept, levelled, memory_for(size)) {}

  PanoramaSize size() const { return pictures_.map_size(); }

  InverseDistanceMap map_at(const SweepReference& reference, bool refine) {
    const TileViews views(reference, candidates_near(plan_, reference), plan_.reach_m, &pictures_);
    sweep(views, layers_, &volume_);
    InverseDistanceMap map = regularise(volume_, reference, &scratch_);
    if (refine) refine_parallax(views, plan_.reach_m, &map);
    return map;
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

// Sweeps the stations of `share` without a stored map of the stage. `see` is called with every map,
// in order.
template <typename See>
void sweep_all(const DepthPlan& plan, IndexRange share, const SweepRun& run, StationSweep* sweep,
               PartialMaps* partial, const See& see) {
  Progress progress(run.progress, static_cast<std::int64_t>(share.size()), "stations");
  for (const SweepReference& reference : maps_of(plan, share)) {
    throw_if_interrupted();
    auto map = partial->load(run.stage, reference.station, reference.position_m, sweep->size());
    if (!map) {
      map = sweep->map_at(reference, run.refine);
      partial->store(run.stage, *map);
    }
    see(*map);
    progress.advance();
  }
}

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

// The largest inverse distance that is looked for.
double sweep_limit_per_m(const DepthPlan& plan) { return 1.0 / (kNearestPerReach * plan.reach_m); }

}  // namespace

PanoramaSize coarse_size(const DepthPlan& plan) {
  constexpr int kReduction = 4;
  return {plan.size.width / kReduction, plan.size.height / kReduction};
}

OmegaHistogram near_surfaces(const Room& room, const DepthPlan& plan,
                             const std::vector<std::vector<GainField>>& gains, const cv::Mat& valid,
                             IndexRange share, const std::filesystem::path& scratch) {
  OmegaHistogram histogram(sweep_limit_per_m(plan));
  StationSweep sweep(room, plan, coarse_size(plan), sweep_limit_per_m(plan), gains, valid, true,
                     scratch);
  for (const SweepReference& reference : maps_of(plan, share)) {
    throw_if_interrupted();
    histogram.add(sweep.map_at(reference, false));
  }
  return histogram;
}

OmegaHistogram sum_of_histograms(const DepthPlan& plan, const std::vector<std::string>& parts) {
  OmegaHistogram sum(sweep_limit_per_m(plan));
  for (const std::string& part : parts) sum.add(OmegaHistogram(sweep_limit_per_m(plan), part));
  return sum;
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

OmegaHistogram sweep_coarse_maps(const Room& room, const DepthPlan& plan,
                                 const std::vector<std::vector<GainField>>& gains,
                                 const cv::Mat& valid, IndexRange share, PartialMaps* partial) {
  OmegaHistogram histogram(sweep_limit_per_m(plan));
  StationSweep sweep(room, plan, coarse_size(plan), sweep_limit_per_m(plan), gains, valid, true,
                     partial->directory());
  sweep_all(plan, share, {"looking for the nearest surfaces", kCoarseStage, false}, &sweep, partial,
            [&](const InverseDistanceMap& map) { histogram.add(map); });
  return histogram;
}

double nearest_surfaces_per_m(const DepthPlan& plan, const OmegaHistogram& histogram) {
  // The share of the pixels that may lie nearer than the sweep's near limit: false matches are
  // spread over all layers.
  constexpr double kNearer = 0.001;
  constexpr double kMargin = 1.25;
  return std::min(sweep_limit_per_m(plan), kMargin * histogram.exceeded_by(kNearer));
}

void sweep_maps(const Room& room, const DepthPlan& plan, double max_per_m,
                const std::vector<std::vector<GainField>>& gains, const cv::Mat& valid,
                IndexRange share, PartialMaps* partial) {
  StationSweep sweep(room, plan, plan.size, max_per_m, gains, valid, false, partial->directory());
  sweep_all(plan, share, {"sweeping", kSweptStage, true}, &sweep, partial,
            [](const InverseDistanceMap&) {});
}

std::vector<int> fused_with(const DepthPlan& plan, bool masked, int which) {
  std::vector<int> voters = voters_of(plan, which);
  if (!masked) return voters;
  const std::vector<int> farther = fallback_voters_of(plan, voters);
  voters.insert(voters.end(), farther.begin(), farther.end());
  return voters;
}

void fuse_swept_maps(const Room& room, const DepthPlan& plan,
                     const std::vector<std::vector<GainField>>& gains, IndexRange share,
                     PartialMaps* partial, const SeeMap& see) {
  // 1.5 pixels of parallax at the reach: both maps are off by up to half a layer, and their pixels
  // do not coincide.
  constexpr double kAgreePx = 1.5;
  // With six voters, two maps that agree are enough for kMinConfidence.
  constexpr int kMinVoters = 6;
  FusionOptions options{.tolerance_per_m = kAgreePx / plan.pixels_per_omega_m()};
  const bool masked = room.masked();
  if (masked) options.min_voters = kMinVoters;
  VoterColours colours(room, plan, gains);
  Progress progress("fusing", static_cast<std::int64_t>(share.size()), "maps");
  for (std::size_t i = share.begin; i < share.end; ++i) {
    throw_if_interrupted();
    const SweepReference& own = plan.maps[i];
    auto map = partial->load(kFinalStage, own.station, own.position_m, plan.size);
    if (!map) {
      const std::vector<int> voters = fused_with(plan, masked, static_cast<int>(i));
      const std::size_t near = masked ? voters_of(plan, static_cast<int>(i)).size() : voters.size();
      options.fallback_maps = static_cast<int>(voters.size() - near);
      std::vector<InverseDistanceMap> maps;
      for (const int voter : voters) {
        const SweepReference& reference = plan.maps[static_cast<size_t>(voter)];
        maps.push_back(
            partial->load_stored(kSweptStage, reference.station, reference.position_m, plan.size));
      }
      map = fuse_maps(maps, 0, options, colours.of(voters));
      partial->store(kVotedStage, *map);
      complete_map(station_image(room, own.station, plan.size),
                   station_validity(room, own.station, plan.size, 0), options.tolerance_per_m,
                   &*map);
      partial->store(kFinalStage, *map);
    }
    see(*map);
    progress.advance();
  }
}

}  // namespace raywalk::build_lf
