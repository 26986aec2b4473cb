#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <span>
#include <utility>

#include "build_lf/depth/depth_steps.h"
#include "build_lf/depth/depth_work.h"
#include "build_lf/depth/finish_maps.h"
#include "build_lf/depth/flow_depth.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/depth/station_links.h"
#include "build_lf/depth/sweep_depth.h"
#include "build_lf/gains/make_gains.h"
#include "build_lf/gains/room_gains.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"

namespace raywalk::build_lf {
namespace {

// The number of a line's first station, counted through all lines.
std::size_t first_station(const Grid& grid, int line) {
  std::size_t first = 0;
  for (int l = 0; l < line; ++l) first += grid.lines[static_cast<size_t>(l)].stations.size();
  return first;
}

std::string compare_colours(const Room& room, std::span<const StationIndex> stations,
                            const SurfaceMaps& maps, IndexRange share) {
  const auto progress = comparison_progress(share.size());
  return bytes_of(compare_stations(room, stations, maps, share, progress.get()));
}

}  // namespace

std::size_t DepthWork::pieces(DepthStep step) {
  const Grid& grid = room_.grid();
  switch (step) {
    case DepthStep::kLinks:
      return pairs_to_compare(grid).size();
    case DepthStep::kReach:
      return plan_before_reach().maps.size();
    case DepthStep::kVolumes:
      return grid.lines.size();
    case DepthStep::kColours:
    case DepthStep::kMoved:
    case DepthStep::kGains:
      return first_station(grid, static_cast<int>(grid.lines.size()));
    default:
      return plan().maps.size();
  }
}

std::string DepthWork::run(DepthStep step, Block block) {
  const IndexRange share = block.share_of(pieces(step));
  switch (step) {
    case DepthStep::kLinks: {
      const std::vector<StationPair> pairs = pairs_to_compare(room_.grid());
      return bytes_of(measure_links(room_, std::span(pairs).subspan(share.begin, share.size())));
    }
    case DepthStep::kReach:
      return near_surfaces(room_, plan_before_reach(), valid_, share, partial_.directory()).bytes();
    case DepthStep::kSurfaces:
      return sweep_coarse_maps(room_, plan(), valid_, share, &partial_).bytes();
    case DepthStep::kColours:
      require(DepthStep::kSurfaces);
      return compare_colours(room_, all_stations(room_.grid()), coarse_maps(), share);
    case DepthStep::kSweep:
      if (options_.method == DepthMethod::kFlow) return make_flow_maps(share);
      sweep_maps(room_, plan(), nearest_per_m(), matching_gains(), valid_, share, &partial_);
      return "";
    case DepthStep::kChoose:
      for (std::size_t i = share.begin; i < share.end; ++i) {
        require_maps(DepthStep::kSweep, kSweptStage, seen_from(plan(), static_cast<int>(i)));
      }
      choose_maps(room_, plan(), matching_gains(), valid_, share, &partial_);
      return "";
    case DepthStep::kFuse:
      return make_fused_maps(share);
    case DepthStep::kMoved:
      require(DepthStep::kSweep);
      require(DepthStep::kFuse);
      return bytes_of(find_contradictions(
                          room_, plan(), matching_gains(),
                          [&](const SweepReference& map) { return final_map(map); }, share)
                          .stations);
    case DepthStep::kVolumes:
      require(DepthStep::kSweep);
      require(DepthStep::kFuse);
      require(DepthStep::kMoved);
      write_volumes(room_, options_.method, plan(), partial_, block.share_of(maps_by_line()),
                    [&](int line) { return contradictions_of(line); });
      return "";
    case DepthStep::kGains:
      return compare_final_colours(block);
  }
  return "";
}

SurfaceMaps DepthWork::coarse_maps() {
  const PanoramaSize size = coarse_size(plan());
  SurfaceMaps maps{size, {}, {}, valid_};
  std::map<StationIndex, Eigen::Vector3d> position_m;
  for (const SweepReference& map : plan().maps) {
    maps.stations.push_back(map.station);
    position_m.emplace(map.station, map.position_m);
  }
  maps.read = [this, size, positions_m = std::move(position_m)](StationIndex station) {
    return partial_.load_stored(kCoarseStage, station, positions_m.at(station), size);
  };
  return maps;
}

std::string DepthWork::make_flow_maps(IndexRange share) {
  Progress progress("following the flow", static_cast<std::int64_t>(share.size()), "maps");
  std::vector<MapSummary> summaries;
  for (std::size_t i = share.begin; i < share.end; ++i) {
    throw_if_interrupted();
    const SweepReference& own = plan().maps[i];
    auto map = partial_.load(kFinalStage, own.station, own.position_m, plan().size);
    if (!map) {
      map = flow_map(room_, own.station, plan().reach_m, plan().size, matching_gains());
      partial_.store(kFinalStage, *map);
    }
    summaries.push_back(summary_of(*map));
    progress.advance();
  }
  return bytes_of(summaries);
}

void DepthWork::require_maps(DepthStep step, const char* stage, const std::vector<int>& maps) {
  for (const int map : maps) {
    if (!partial_.has(stage, plan().maps[static_cast<size_t>(map)].station)) require(step);
  }
}

std::string DepthWork::make_fused_maps(IndexRange share) {
  for (std::size_t i = share.begin; i < share.end; ++i) {
    require_maps(DepthStep::kChoose, kChosenStage,
                 fused_with(plan(), room_.masked(), static_cast<int>(i)));
  }
  std::vector<MapSummary> summaries;
  fuse_chosen_maps(room_, plan(), matching_gains(), share, &partial_,
                   [&](const InverseDistanceMap& map) { summaries.push_back(summary_of(map)); });
  return bytes_of(summaries);
}

std::string DepthWork::compare_final_colours(Block block) {
  require(DepthStep::kVolumes);
  const Room estimated = room_.with_distances(partial_.volumes());
  const std::vector<StationIndex> stations = all_stations(estimated.grid());
  return compare_colours(estimated, stations, surface_maps_of(estimated),
                         block.share_of(stations.size()));
}

std::vector<std::uint64_t> DepthWork::maps_by_line() {
  std::vector<std::uint64_t> maps(room_.grid().lines.size());
  for (const SweepReference& map : plan().maps) ++maps[static_cast<size_t>(map.station.line)];
  return maps;
}

Contradictions DepthWork::contradictions_of(int line) {
  Contradictions of_line = no_contradictions(plan());
  if (!has(DepthStep::kMoved)) return of_line;
  const BlockResults moved = results(DepthStep::kMoved);
  const int count = moved.complete_count().value();
  const std::size_t stations = pieces(DepthStep::kMoved);
  const std::size_t begin = first_station(room_.grid(), line);
  const std::size_t end = first_station(room_.grid(), line + 1);
  for (int index = 1; index <= count; ++index) {
    const IndexRange share = Block{index, count}.share_of(stations);
    if (share.end <= begin || share.begin >= end) continue;
    if (read_block_ != index) {
      read_contradictions_ = contradicted_stations_of(moved.result_of({index, count}));
      read_block_ = index;
    }
    std::ranges::copy_if(read_contradictions_, std::back_inserter(of_line.stations),
                         [&](const auto& found) { return found.station.line == line; });
  }
  return of_line;
}

MapSummary DepthWork::summary_of(const InverseDistanceMap& map) {
  const Line& line = room_.grid().lines[static_cast<size_t>(map.station.line)];
  MapSummary summary{line.id, map.station.station,
                     line.stations[static_cast<size_t>(map.station.station)].file};
  double total = 0.0;
  for (size_t p = 0; p < map.confidence.size(); ++p) {
    const double row = static_cast<double>(p % static_cast<size_t>(map.size.height));
    const double weight = std::cos(angles_from_pixel({0.0, row}, map.size).phi_rad);
    const double confidence = map.confidence[p] / 255.0;
    total += weight;
    summary.mean_confidence += weight * confidence;
    if (map.confidence[p] < kMinConfidence) summary.low_share += weight;
    if (map.omega[p] * plan().pixels_per_omega_m() >= 1.0) summary.parallax_share += weight;
  }
  summary.mean_confidence /= total;
  summary.low_share /= total;
  summary.parallax_share /= total;
  return summary;
}

}  // namespace raywalk::build_lf
