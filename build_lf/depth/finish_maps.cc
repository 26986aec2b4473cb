#include "build_lf/depth/finish_maps.h"

#include <memory_resource>
#include <span>
#include <utility>

#include "build_lf/depth/file_memory.h"
#include "build_lf/depth/map_fusion.h"
#include "build_lf/depth/station_colours.h"
#include "build_lf/depth/surface_choice.h"
#include "build_lf/depth/sweep_depth.h"
#include "core/base/recently_made.h"
#include "core/base/usable_memory.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

const SweepReference& map_of(const DepthPlan& plan, int which) {
  return plan.maps[static_cast<size_t>(which)];
}

StationColours colours_of(const Room& room, const DepthPlan& plan, const GainFields& gains,
                          int which) {
  const StationIndex station = plan.station_of(which);
  return station_colours(room, station, plan.size, gain_field(gains, station));
}

// Where a station shows the scene, [theta][phi]; empty: everywhere.
cv::Mat shown_by(const Room& room, const DepthPlan& plan, const cv::Mat& valid, int which) {
  cv::Mat own = station_validity(room, plan.station_of(which), plan.size, 0);
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

void choose_maps(const Room& room, const DepthPlan& plan, const GainFields& gains,
                 const cv::Mat& valid, IndexRange share, PartialMaps* partial) {
  FileMemory files(partial->directory());
  // Neighbouring maps share most of what they are compared with.
  RecentlyMade<int, ChoiceSource> sources(kMostChoiceViews, [&](int which) {
    const cv::Mat sampled =
        sampled_ranges(colours_of(room, plan, gains, which), shown_by(room, plan, valid, which));
    const bool fits =
        sampled.total() * sizeof(ColourRange) * kMostChoiceViews <= usable_memory_bytes() / 2;
    const auto* first = sampled.ptr<ColourRange>();
    return ChoiceSource{
        {first, first + sampled.total(), fits ? std::pmr::get_default_resource() : &files},
        partial->stored(kSweptStage, plan.station_of(which))};
  });
  make_maps(plan, share, kChosenStage, "choosing surfaces", partial, [&](int i) {
    const auto seen = sources.get_all(seen_from(plan, i));
    std::vector<ChoiceView> views;
    views.reserve(seen.size());
    for (const auto& source : seen) views.push_back({source->ranges, &source->map});
    return choose_surfaces(partial->stored(kSweptStage, plan.station_of(i)),
                           colours_of(room, plan, gains, i), views,
                           1.0 / plan.pixels_per_inverse_m());
  });
}

std::vector<int> fused_with(const DepthPlan& plan, bool masked, int which) {
  std::vector<int> voters = voters_of(plan, which);
  if (!masked) return voters;
  const std::vector<int> farther = fallback_voters_of(plan, voters);
  voters.insert(voters.end(), farther.begin(), farther.end());
  return voters;
}

void fuse_chosen_maps(const Room& room, const DepthPlan& plan, const GainFields& gains,
                      IndexRange share, PartialMaps* partial) {
  // 1.5 pixels of parallax at the reach: both maps are off by up to half a layer, and their pixels
  // do not coincide.
  constexpr double kAgreePx = 1.5;
  // With six voters, two maps that agree are enough for kMinConfidence.
  constexpr int kMinVoters = 6;
  // fused_with() is about as many.
  constexpr std::size_t kMostFused = 24;
  FusionOptions options{.tolerance_per_m = kAgreePx / plan.pixels_per_inverse_m()};
  const bool masked = room.masked();
  if (masked) options.min_voters = kMinVoters;
  RecentlyMade<int, cv::Mat> colours(
      kMostFused, [&](int which) { return ranges_of(colours_of(room, plan, gains, which)); });
  make_maps(plan, share, kFinalStage, "fusing", partial, [&](int i) {
    const std::vector<int> voters = fused_with(plan, masked, i);
    const std::size_t near = masked ? voters_of(plan, i).size() : voters.size();
    options.fallback_maps = static_cast<int>(voters.size() - near);
    std::vector<InverseDistanceMap> maps;
    std::vector<cv::Mat> ranges;
    maps.reserve(voters.size());
    ranges.reserve(voters.size());
    for (const auto& known : colours.get_all(voters)) ranges.push_back(*known);
    for (const int voter : voters) {
      maps.push_back(partial->stored(kChosenStage, plan.station_of(voter)));
    }
    return fuse_maps(maps, 0, options, ranges);
  });
}

}  // namespace raywalk::build_lf
