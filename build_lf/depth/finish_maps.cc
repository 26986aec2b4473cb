#include "build_lf/depth/finish_maps.h"

#include <functional>
#include <map>
#include <memory_resource>
#include <span>
#include <utility>

#include "build_lf/depth/file_memory.h"
#include "build_lf/depth/map_fusion.h"
#include "build_lf/depth/station_colours.h"
#include "core/room/station_image.h"
#include "build_lf/depth/surface_choice.h"
#include "build_lf/depth/sweep_depth.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/base/usable_memory.h"

namespace raywalk::build_lf {
namespace {

// What is made of maps of the plan. Neighbouring maps share most of it: it is kept for the next.
template <typename Made>
class Kept {
 public:
  explicit Kept(std::function<Made(int map)> make) : make_(std::move(make)) {}

  // Of all `maps`; what is of others is dropped.
  const std::map<int, Made>& of(std::span<const int> maps) {
    std::map<int, Made> all;
    std::vector<int> missing;
    for (const int map : maps) {
      if (auto known = kept_.extract(map)) {
        all.insert(std::move(known));
      } else {
        all.try_emplace(map);
        missing.push_back(map);
      }
    }
    parallel_for(0, static_cast<int>(missing.size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const int map = missing[static_cast<size_t>(i)];
        all.at(map) = make_(map);
      }
    });
    kept_ = std::move(all);
    return kept_;
  }

 private:
  std::function<Made(int)> make_;
  std::map<int, Made> kept_;
};

const SweepReference& map_of(const DepthPlan& plan, int which) {
  return plan.maps[static_cast<size_t>(which)];
}

StationColours colours_of(const Room& room, const DepthPlan& plan,
                          const std::vector<std::vector<GainField>>& gains, int which) {
  const StationIndex station = map_of(plan, which).station;
  return station_colours(
      room, station, plan.size,
      gains[static_cast<size_t>(station.line)][static_cast<size_t>(station.station)]);
}

InverseDistanceMap stored_map(const PartialMaps& partial, const char* stage, const DepthPlan& plan,
                              int which) {
  const SweepReference& map = map_of(plan, which);
  return partial.load_stored(stage, map.station, map.position_m, plan.size);
}

// Where a station shows the scene, [theta][phi]; empty: everywhere.
cv::Mat shown_by(const Room& room, const DepthPlan& plan, const cv::Mat& valid, int which) {
  cv::Mat own = station_validity(room, map_of(plan, which).station, plan.size, 0);
  if (valid.empty()) return own;
  return own.empty() ? cv::Mat(valid.t()) : cv::Mat(valid.t() & own);
}

// What a ChoiceView refers to.
struct ChoiceSource {
  std::pmr::vector<ColourRange> ranges{};
  InverseDistanceMap map{};
};

}  // namespace

std::vector<int> seen_from(const DepthPlan& plan, int which) {
  const Eigen::Vector3d& from_m = map_of(plan, which).position_m;
  std::vector<int> near;
  for (int i = 0; i < static_cast<int>(plan.maps.size()); ++i) {
    const double away_m = (map_of(plan, i).position_m - from_m).norm();
    if (i != which && away_m <= 3.0 * plan.reach_m) near.push_back(i);
  }
  const int step = (static_cast<int>(near.size()) + kMostChoiceViews - 1) / kMostChoiceViews;
  std::erase_if(near, [step](int i) { return i % step != 0; });
  return near;
}

void choose_maps(const Room& room, const DepthPlan& plan,
                 const std::vector<std::vector<GainField>>& gains, const cv::Mat& valid,
                 IndexRange share, PartialMaps* partial) {
  FileMemory files(partial->directory());
  Kept<ChoiceSource> sources([&](int which) {
    const cv::Mat sampled =
        sampled_ranges(colours_of(room, plan, gains, which), shown_by(room, plan, valid, which));
    const bool fits =
        sampled.total() * sizeof(ColourRange) * kMostChoiceViews <= usable_memory_bytes() / 2;
    const auto* first = sampled.ptr<ColourRange>();
    return ChoiceSource{
        {first, first + sampled.total(), fits ? std::pmr::get_default_resource() : &files},
        stored_map(*partial, kSweptStage, plan, which)};
  });
  Progress progress("choosing surfaces", static_cast<std::int64_t>(share.size()), "maps");
  for (auto i = static_cast<int>(share.begin); i < static_cast<int>(share.end); ++i) {
    throw_if_interrupted();
    const SweepReference& own = map_of(plan, i);
    if (!partial->load(kChosenStage, own.station, own.position_m, plan.size)) {
      std::vector<ChoiceView> views;
      for (const auto& [which, source] : sources.of(seen_from(plan, i))) {
        views.push_back({source.ranges, &source.map});
      }
      partial->store(kChosenStage, choose_surfaces(stored_map(*partial, kSweptStage, plan, i),
                                                   colours_of(room, plan, gains, i), views,
                                                   1.0 / plan.pixels_per_omega_m()));
    }
    progress.advance();
  }
}

std::vector<int> fused_with(const DepthPlan& plan, bool masked, int which) {
  std::vector<int> voters = voters_of(plan, which);
  if (!masked) return voters;
  const std::vector<int> farther = fallback_voters_of(plan, voters);
  voters.insert(voters.end(), farther.begin(), farther.end());
  return voters;
}

void fuse_chosen_maps(const Room& room, const DepthPlan& plan,
                      const std::vector<std::vector<GainField>>& gains, IndexRange share,
                      PartialMaps* partial) {
  // 1.5 pixels of parallax at the reach: both maps are off by up to half a layer, and their pixels
  // do not coincide.
  constexpr double kAgreePx = 1.5;
  // With six voters, two maps that agree are enough for kMinConfidence.
  constexpr int kMinVoters = 6;
  FusionOptions options{.tolerance_per_m = kAgreePx / plan.pixels_per_omega_m()};
  const bool masked = room.masked();
  if (masked) options.min_voters = kMinVoters;
  Kept<cv::Mat> colours([&](int which) { return ranges_of(colours_of(room, plan, gains, which)); });
  Progress progress("fusing", static_cast<std::int64_t>(share.size()), "maps");
  for (auto i = static_cast<int>(share.begin); i < static_cast<int>(share.end); ++i) {
    throw_if_interrupted();
    const SweepReference& own = map_of(plan, i);
    if (!partial->load(kFinalStage, own.station, own.position_m, plan.size)) {
      const std::vector<int> voters = fused_with(plan, masked, i);
      const std::size_t near = masked ? voters_of(plan, i).size() : voters.size();
      options.fallback_maps = static_cast<int>(voters.size() - near);
      const std::map<int, cv::Mat>& known = colours.of(voters);
      std::vector<InverseDistanceMap> maps;
      std::vector<cv::Mat> ranges;
      for (const int voter : voters) {
        maps.push_back(stored_map(*partial, kChosenStage, plan, voter));
        ranges.push_back(known.at(voter));
      }
      partial->store(kFinalStage, fuse_maps(maps, 0, options, ranges));
    }
    progress.advance();
  }
}

}  // namespace raywalk::build_lf
