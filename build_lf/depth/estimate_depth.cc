#include "build_lf/depth/estimate_depth.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/depth_truth.h"
#include "build_lf/depth/depth_work.h"
#include "build_lf/depth/map_images.h"
#include "build_lf/depth/plane_sweep.h"
#include "build_lf/distance_sets.h"
#include "build_lf/gains/make_gains.h"
#include "core/base/error.h"
#include "core/base/pick_evenly.h"
#include "core/files/atomic_output.h"
#include "core/files/json_text.h"

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
    shown.push_back(work->final_map(*middles[static_cast<size_t>(i)]));
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

void log_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) spdlog::warn("{}", warning);
}

void add(const std::vector<std::string>& warnings, DepthSummary* summary) {
  summary->warnings.insert(summary->warnings.end(), warnings.begin(), warnings.end());
}

// What the complete steps found.
DepthSummary collected(DepthWork* work) {
  const DepthOptions& options = work->options();
  const ExaminedFrames& frames = work->frames();
  DepthSummary summary{.room = options.room.string(),
                       .method = name_of(options.method),
                       .size = work->plan().size,
                       .stations = static_cast<int>(all_stations(work->room().grid()).size()),
                       .every = options.every,
                       .hold_out = options.hold_out,
                       .valid_mask = options.valid_mask.value_or(fs::path()).string(),
                       .reach_m = work->plan().reach_m,
                       .largest_exposure_step = frames.checks.largest_exposure_step,
                       .maps = work->map_summaries(),
                       .leave_out_moving = options.leave_out_moving,
                       .left_out = work->left_out(),
                       .frame_findings = frames.checks.frames};
  if (options.method == DepthMethod::kSweep) {
    const double max_per_m = work->nearest_per_m();
    summary.nearest_m = 1.0 / max_per_m;
    summary.layers = sweep_layers(max_per_m, summary.reach_m, summary.size).count;
  }
  add(warnings_of(work->room(), frames.checks), &summary);
  const auto parallax = parallax_warnings(summary.maps, work->plan().pixels_per_omega_m());
  log_warnings(parallax);
  add(parallax, &summary);
  return summary;
}

// Throws Error naming the blocks of every step that are missing. The shares of the later steps are
// known only once the first are complete.
void require_all_steps(DepthWork* work) {
  for (const DepthStep step : {DepthStep::kLinks, DepthStep::kReach}) work->require(step);
  std::string all;
  for (const DepthStep step : kDepthSteps) {
    const std::string missing = work->missing(step);
    if (!missing.empty()) {
      all += fmt::format("{}{}: {}", all.empty() ? "" : "; ", name_of(step), missing);
    }
  }
  if (all.empty()) return;
  throw Error(fmt::format("{}: these steps are not complete: {}; make them with --step and --block",
                          work->options().room.string(), all));
}

// Puts the finished volumes where they are used, and reports.
DepthSummary finish(DepthWork* work, const std::optional<GivenDistances>& truth,
                    std::chrono::steady_clock::time_point start) {
  DepthSummary summary = collected(work);
  const DepthOptions& options = work->options();
  if (truth) summary.truth = compare_with_truth(*truth, work->plan(), work->partial());
  const std::vector<InverseDistanceMap> shown = maps_to_show(work);
  std::optional<GainFields> gains;
  if (work->has(DepthStep::kGains)) gains = work->room_gains();
  work->install();
  set_use(options.room, &summary);
  if (gains) {
    replace_gains(options.room, *gains);
    summary.gains = summary_of(*gains);
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
  DepthWork work(options, MapsUse::kWhole);
  std::optional<GivenDistances> truth;
  if (options.compare_truth) truth = truth_of(options);
  for (const DepthStep step : kDepthSteps) {
    if (!work.has(step)) continue;
    work.complete(step);
    // Before hours of work.
    if (step == DepthStep::kLinks) log_warnings(warnings_of(work.room(), work.frames().checks));
  }
  return finish(&work, truth, start);
}

std::string estimate_block(const DepthOptions& options, DepthStep step, Block block) {
  DepthWork work(options, MapsUse::kBlock);
  const std::string name =
      fmt::format("{}: step {}, block {}", options.room.string(), name_of(step), block.text());
  if (!work.has(step)) return name + ": this run has no such step";
  return name + (work.make(step, block) ? "" : ": was done before");
}

std::string merge_step(const DepthOptions& options, DepthStep step) {
  DepthWork work(options, MapsUse::kMerge);
  const std::string name = fmt::format("{}: step {}", options.room.string(), name_of(step));
  if (!work.has(step)) return name + ": this run has no such step";
  work.require(step);
  if (step == DepthStep::kLinks) log_warnings(warnings_of(work.room(), work.frames().checks));
  if (step == DepthStep::kColours) work.matching_gains();
  return name + " is complete";
}

DepthSummary merge_depth(const DepthOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  DepthWork work(options, MapsUse::kMerge);
  std::optional<GivenDistances> truth;
  if (options.compare_truth) truth = truth_of(options);
  require_all_steps(&work);
  log_warnings(warnings_of(work.room(), work.frames().checks));
  return finish(&work, truth, start);
}

}  // namespace raywalk::build_lf
