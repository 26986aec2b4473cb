#include "build_lf/depth/preparation.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "build_lf/depth/depth_summary.h"
#include "build_lf/quality/station_links.h"
#include "build_lf/depth/sweep_depth.h"
#include "build_lf/exposure/make_gains.h"
#include "build_lf/exposure/room_gains.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// What is measured; all else follows from it.
struct Measured {
  std::vector<StationLink> links{};
  double near_m = std::numeric_limits<double>::infinity();  // plan_depth()
  double nearest_per_m = 0.0;
};

fs::path measured_file(const PartialMaps& partial) { return partial.directory() / "measured.json"; }
fs::path gains_file(const PartialMaps& partial) { return partial.directory() / "gains.h5"; }

json json_of(const Measured& measured) {
  json links = json::array();
  for (const auto& [pair, compared] : measured.links) {
    links.push_back({pair.from.line, pair.from.station, pair.to.station, compared.comparable,
                     compared.log_ratio, compared.change, compared.unexplained_change});
  }
  json document{{"links", std::move(links)}, {"nearest_per_m", measured.nearest_per_m}};
  if (std::isfinite(measured.near_m)) document["near_m"] = measured.near_m;
  return document;
}

// Throws json::exception.
Measured measured_from(const json& document) {
  Measured measured;
  measured.near_m = document.value("near_m", measured.near_m);
  document.at("nearest_per_m").get_to(measured.nearest_per_m);
  for (const json& entry : document.at("links")) {
    const int line = entry.at(0).get<int>();
    StationLink& link = measured.links.emplace_back();
    link.pair = {{line, entry.at(1).get<int>()}, {line, entry.at(2).get<int>()}};
    entry.at(3).get_to(link.compared.comparable);
    entry.at(4).get_to(link.compared.log_ratio);
    entry.at(5).get_to(link.compared.change);
    entry.at(6).get_to(link.compared.unexplained_change);
  }
  return measured;
}

// The plan without frames at a wrong position, or that show something that moved.
DepthPlan plan_without_faults(const Room& room, const DepthOptions& options,
                              const FrameChecks& checks, double near_m) {
  std::vector<StationIndex> faulty;
  for (const FrameFinding& finding : checks.frames) {
    if (finding.fault != FrameFault::kExposureStep) faulty.push_back(finding.station);
  }
  DepthPlan plan = plan_depth(room, options, near_m);
  exclude_stations(faulty, &plan);
  return plan;
}

// All but the gains.
Preparation preparation_of(const Room& room, const DepthOptions& options,
                           const Measured& measured) {
  Preparation preparation;
  preparation.checks = check_frames(room, measured.links, plan_depth(room, options).reach_m);
  preparation.plan = plan_without_faults(room, options, preparation.checks, measured.near_m);
  preparation.nearest_per_m = measured.nearest_per_m;
  return preparation;
}

SurfaceMaps coarse_maps(const DepthPlan& plan, const cv::Mat& valid, const PartialMaps& partial) {
  SurfaceMaps maps{coarse_size(plan), {}, {}, valid};
  std::map<StationIndex, Eigen::Vector3d> positions_m;
  for (const SweepReference& map : plan.maps) {
    maps.stations.push_back(map.station);
    positions_m.emplace(map.station, map.position_m);
  }
  maps.read = [&partial, size = maps.size,
               positions_m = std::move(positions_m)](StationIndex station) {
    return partial.load_stored(kCoarseStage, station, positions_m.at(station), size);
  };
  return maps;
}

// Stores the gains, and returns them as they are read again, so that this run and those that read
// them have the same. Gains of 1 are not stored.
GainFields kept_gains(const Room& room, GainFields gains, const PartialMaps& partial) {
  const bool all_are_one = std::ranges::all_of(
      gains, [](const auto& line) { return std::ranges::all_of(line, is_one); });
  fs::remove(gains_file(partial));
  if (all_are_one) return gains;
  write_gain_fields(gains_file(partial), room.grid(), gains);
  return read_gain_fields(gains_file(partial), room.grid());
}

}  // namespace

Preparation prepare_depth(const Room& room, const DepthOptions& options, const cv::Mat& valid,
                          PartialMaps* partial) {
  Measured measured;
  measured.links = measure_links(room, pairs_to_compare(room.grid()));
  Preparation preparation = preparation_of(room, options, measured);
  warn_of(room, preparation.checks);  // before hours of work
  if (options.method == DepthMethod::kSweep && room.grid().cells.empty()) {
    // Without cells, the lines do not tell how far away the scene is.
    measured.near_m = near_distance_m(
        preparation.plan, near_surfaces(room, preparation.plan, valid, partial->directory()));
    preparation.plan = plan_without_faults(room, options, preparation.checks, measured.near_m);
  }
  const DepthPlan& plan = preparation.plan;
  measured.nearest_per_m =
      nearest_surfaces_per_m(plan, sweep_coarse_maps(room, plan, valid, partial));
  preparation.nearest_per_m = measured.nearest_per_m;
  preparation.gains = kept_gains(
      room, solve_room_gains(room, all_stations(room.grid()), coarse_maps(plan, valid, *partial)),
      *partial);
  write_file_atomically(measured_file(*partial), json_of(measured).dump());
  return preparation;
}

std::optional<Preparation> kept_preparation(const Room& room, const DepthOptions& options,
                                            const PartialMaps& partial) {
  if (!fs::exists(measured_file(partial))) return std::nullopt;
  Measured measured;
  GainFields gains = unit_gain_fields(room.grid());
  try {
    measured = measured_from(json::parse(read_file(measured_file(partial))));
    if (fs::exists(gains_file(partial))) {
      gains = read_gain_fields(gains_file(partial), room.grid());
    }
  } catch (const json::exception&) {
    return std::nullopt;
  } catch (const Error&) {
    return std::nullopt;
  }
  Preparation preparation = preparation_of(room, options, measured);
  preparation.gains = std::move(gains);
  return preparation;
}

void warn_of(const Room& room, const FrameChecks& checks) {
  for (const std::string& warning : warnings_of(room, checks)) spdlog::warn("{}", warning);
}

}  // namespace raywalk::build_lf
