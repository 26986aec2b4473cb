#include "build_lf/depth/sweep_depth.h"

#include <algorithm>
#include <cmath>

#include "build_lf/depth/map_fusion.h"
#include "build_lf/depth/parallax_refinement.h"
#include "build_lf/depth/semi_global.h"
#include "core/base/interrupt.h"
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
      const TileViews views(reference, candidates_near(plan, reference), plan.reach_m, pictures);
      sweep(views, layers, &volume);
      map = regularise(volume, reference, &scratch);
      if (run.refine) refine_parallax(views, plan.reach_m, &*map);
      partial->store(run.stage, *map);
    }
    see(*map);
    progress.advance();
  }
}

}  // namespace

double find_nearest_surfaces(const Room& room, const DepthPlan& plan,
                             const std::vector<std::vector<ColourGain>>& gains,
                             const cv::Mat& valid, PartialMaps* partial) {
  constexpr int kReduction = 4;
  constexpr double kNearestPerReach = 0.25;
  // Minimum confidence of the pixels counted, and the share of them that may lie nearer than the
  // sweep's near limit: false matches are spread over all layers.
  constexpr int kConfident = 64;
  constexpr double kNearer = 0.001;
  constexpr double kMargin = 1.25;
  constexpr int kBins = 1024;
  const PanoramaSize size{plan.size.width / kReduction, plan.size.height / kReduction};
  const double limit = 1.0 / (kNearestPerReach * plan.reach_m);
  std::vector<double> histogram(kBins);
  double total = 0.0;
  PictureCache pictures(room, size, gains, valid, kPicturesKept);
  sweep_all(
      plan, {"looking for the nearest surfaces", "coarse", limit, false}, &pictures, partial,
      [&](const InverseDistanceMap& map) {
        for (size_t p = 0; p < map.omega.size(); ++p) {
          if (map.confidence[p] < kConfident) continue;
          const double phi_rad =
              angles_from_pixel({0.0, double(p % static_cast<size_t>(size.height))}, size).phi_rad;
          const auto bin =
              static_cast<size_t>(std::clamp(map.omega[p] / limit * kBins, 0.0, kBins - 1.0));
          histogram[bin] += std::cos(phi_rad);
          total += std::cos(phi_rad);
        }
      });
  int bin = kBins - 1;
  for (double nearer = 0.0; bin > 0; --bin) {
    nearer += histogram[static_cast<size_t>(bin)];
    if (nearer > kNearer * total) break;
  }
  return std::min(limit, kMargin * limit * (bin + 1) / kBins);
}

void sweep_maps(const Room& room, const DepthPlan& plan, double max_per_m,
                const std::vector<std::vector<ColourGain>>& gains, const cv::Mat& valid,
                PartialMaps* partial) {
  PictureCache pictures(room, plan.size, gains, valid, kPicturesKept);
  sweep_all(plan, {"sweeping", kSweptStage, max_per_m, true}, &pictures, partial,
            [](const InverseDistanceMap&) {});
}

void fuse_swept_maps(const DepthPlan& plan, bool masked, PartialMaps* partial) {
  // 1.5 pixels of parallax at the reach: both maps are off by up to half a layer, and their pixels
  // do not coincide.
  constexpr double kAgreePx = 1.5;
  // With six voters, two maps that agree are enough for kMinConfidence.
  constexpr int kMinVoters = 6;
  FusionOptions options{.tolerance_per_m = kAgreePx / plan.pixels_per_omega_m()};
  if (masked) options.min_voters = kMinVoters;
  const int count = static_cast<int>(plan.maps.size());
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
      partial->store(kFinalStage, fuse_maps(maps, 0, options));
    }
    progress.advance();
  }
}

}  // namespace raywalk::build_lf
