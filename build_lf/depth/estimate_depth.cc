#include "build_lf/depth/estimate_depth.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/depth_truth.h"
#include "build_lf/depth/map_images.h"
#include "build_lf/depth/plane_sweep.h"
#include "build_lf/exposure/make_gains.h"
#include "build_lf/pack/distance_sets.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/pick_evenly.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

double peak_memory_mb() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

// The map in the middle of each line; of many lines, some all over the room.
std::vector<InverseDistanceMap> maps_to_show(DepthWork* work) {
  constexpr int kMostLines = 12;
  const std::vector<SweepReference>& maps = work->plan().maps;
  std::vector<const SweepReference*> middles;
  for (auto begin = maps.begin(); begin != maps.end();) {
    const int line = begin->station.line;
    const auto end = std::find_if(
        begin, maps.end(), [&](const SweepReference& map) { return map.station.line != line; });
    middles.push_back(&*(begin + (end - begin) / 2));
    begin = end;
  }
  std::vector<InverseDistanceMap> shown;
  for (const int i : pick_evenly(static_cast<int>(middles.size()), kMostLines)) {
    shown.push_back(work->final_map(middles[static_cast<size_t>(i)]->station));
  }
  return shown;
}

// Throws Error if there are no given distances.
GivenDistances truth_of(const DepthOptions& options) {
  GivenDistances given(Room::open_rays(options.room));
  if (!given.empty()) return given;
  throw Error(
      fmt::format("{}: --truth: no distances were packed with the room; pack it with --distance",
                  options.room.string()));
}

void set_use(const fs::path& room, DepthSummary* summary) {
  summary->distances = "none";
  for (const FoundDistances& found : find_distances(room, read_manifest(room))) {
    if (found.in_use) summary->distances = found.origin;
    if (!found.in_use && found.kind == DistanceKind::kGiven) {
      summary->kept_given = found.folder.string();
    }
  }
}

MapSummary map_summary(const InverseDistanceMap& map, const Line& line, double pixels_per_omega_m) {
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
    if (map.omega[p] * pixels_per_omega_m >= 1.0) summary.parallax_share += weight;
  }
  summary.mean_confidence /= total;
  summary.low_share /= total;
  summary.parallax_share /= total;
  return summary;
}

std::vector<MapSummary> map_summaries(DepthWork* work) {
  const DepthPlan& plan = work->plan();
  std::vector<MapSummary> summaries(plan.maps.size());
  parallel_for(0, static_cast<int>(plan.maps.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const auto line = static_cast<size_t>(plan.maps[i].station.line);
      summaries[i] = map_summary(work->final_map(plan.maps[i].station),
                                 work->room().grid().lines[line], plan.pixels_per_omega_m());
    }
  });
  return summaries;
}

// Of a line's stations, from the pixels in its finished volume.
void add_left_out(const Line& line, const DistanceVolume& volume,
                  std::vector<LeftOutSummary>* summaries) {
  const PanoramaSize size = volume.size();
  const auto above = [&](int row) { return std::cos(row * kPi / size.height); };
  std::map<int, double> shares;  // by station
  const std::vector<std::int32_t> runs = volume.left_out().stored_runs(size);
  for (size_t i = 0; i < runs.size(); i += 4) {
    shares[runs[i]] += (above(runs[i + 2]) - above(runs[i + 3])) / (2.0 * size.width);
  }
  for (const auto& [station, share] : shares) {
    summaries->push_back(
        {line.id, station, line.stations[static_cast<size_t>(station)].file, share});
  }
}

std::vector<LeftOutSummary> left_out(const Grid& grid, const std::vector<DistanceVolume>& volumes) {
  std::vector<LeftOutSummary> summaries;
  for (size_t l = 0; l < volumes.size(); ++l) {
    if (volumes[l].maps() > 0) add_left_out(grid.lines[l], volumes[l], &summaries);
  }
  return summaries;
}

void add(const std::vector<std::string>& warnings, DepthSummary* summary) {
  summary->warnings.insert(summary->warnings.end(), warnings.begin(), warnings.end());
}

// What the complete steps found.
DepthSummary collected(DepthWork* work) {
  const DepthOptions& options = work->options();
  const FrameChecks& checks = work->prepared().checks;
  const Grid& grid = work->room().grid();
  DepthSummary summary{
      .room = options.room.string(),
      .method = name_of(options.method),
      .size = work->plan().size,
      .stations = static_cast<int>(all_stations(grid).size()),
      .every = options.every,
      .hold_out = options.hold_out,
      .valid_mask = options.valid_mask.value_or(fs::path()).string(),
      .reach_m = work->plan().reach_m,
      .largest_exposure_step = checks.largest_exposure_step,
      .maps = map_summaries(work),
      .leave_out_moving = options.leave_out_moving,
      .left_out = left_out(grid, open_distance_volumes(work->partial().volumes(), grid)),
      .frame_findings = checks.frames};
  if (options.method == DepthMethod::kSweep) {
    const double max_per_m = work->prepared().nearest_per_m;
    summary.nearest_m = 1.0 / max_per_m;
    summary.layers = sweep_layers(max_per_m, summary.reach_m, summary.size).count;
  }
  add(warnings_of(work->room(), checks), &summary);
  const auto parallax = parallax_warnings(summary.maps, work->plan().pixels_per_omega_m());
  for (const std::string& warning : parallax) spdlog::warn("{}", warning);
  add(parallax, &summary);
  return summary;
}

// Puts the finished volumes where they are used, and reports.
DepthSummary finish(DepthWork* work, const std::optional<GivenDistances>& truth,
                    std::chrono::steady_clock::time_point start) {
  DepthSummary summary = collected(work);
  const DepthOptions& options = work->options();
  if (truth) summary.truth = compare_with_truth(*truth, work->plan(), work->partial());
  const std::vector<InverseDistanceMap> shown = maps_to_show(work);
  work->install();
  set_use(options.room, &summary);
  if (options.gains && options.hold_out == 0) {
    replace_gains(options.room, work->prepared().gains);
    summary.gains = summary_of(work->prepared().gains);
  }
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary.peak_memory_mb = peak_memory_mb();
  summary.page = (work->output() / "depth.html").string();
  const nlohmann::ordered_json document = depth_document(summary);
  write_file_atomically(work->output() / "depth.json", json_text(document));
  write_file_atomically(work->output() / "depth.html",
                        report_page("depth", document, map_images(work->room(), shown)));
  return summary;
}

}  // namespace

DepthSummary estimate_depth(const DepthOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  DepthWork work(options, MapsUse::kAlone);
  std::optional<GivenDistances> truth;
  if (options.compare_truth) truth = truth_of(options);
  for (const DepthStep step : kDepthSteps) {
    if (work.has(step)) work.make(step, {});
  }
  return finish(&work, truth, start);
}

std::string estimate_step(const DepthOptions& options, DepthStep step, WorkPart part) {
  const bool alone = step == DepthStep::kPrepare;
  if (alone && part.count > 1) throw UsageError("--part: step prepare is done in one piece");
  DepthWork work(options, alone ? MapsUse::kAlone : MapsUse::kShared);
  const std::string name = fmt::format("{}: step {}", options.room.string(), name_of(step));
  if (!work.has(step)) return name + ": this run has no such step";
  work.make(step, part);
  if (part.count == 1) return name + " is done";
  return fmt::format("{}, part {}/{} is done", name, part.index, part.count);
}

}  // namespace raywalk::build_lf
