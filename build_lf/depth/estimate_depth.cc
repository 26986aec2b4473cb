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

#include "build_lf/depth/contradictions.h"
#include "build_lf/depth/depth_page.h"
#include "build_lf/depth/depth_truth.h"
#include "build_lf/depth/flow_depth.h"
#include "build_lf/depth/frame_checks.h"
#include "build_lf/depth/frame_warnings.h"
#include "build_lf/depth/stored_maps.h"
#include "build_lf/depth/sweep_depth.h"
#include "build_lf/distance_sets.h"
#include "build_lf/gains/make_gains.h"
#include "build_lf/gains/room_gains.h"
#include "build_lf/pack_room.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/pick_evenly.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/json_text.h"
#include "core/files/sha256.h"
#include "core/room/kept_stations.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// Increment when the estimation changes: maps of another version are not resumed.
constexpr int kEstimatorVersion = 3;

double peak_memory_mb() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

std::string fingerprint_of(const Room& room, const DepthOptions& options, const DepthPlan& plan) {
  std::string text = fmt::format("{} {} {}x{}\n", kEstimatorVersion, name_of(options.method),
                                 plan.size.width, plan.size.height);
  for (const SweepReference& map : plan.maps) {
    text += fmt::format("{}/{} ", map.station.line, map.station.station);
  }
  for (const Line& line : room.grid().lines) {
    text += checksum_of_line(line_volume_path(room.directory(), line.id)) + "\n";
  }
  RoomManifest manifest = room.manifest();
  manifest.distances.reset();          // they are not used, and a run changes them
  manifest.gains.clear();              // the same
  text += manifest_to_json(manifest);  // station positions
  if (options.valid_mask) text += read_file(*options.valid_mask);
  return sha256_hex(text);
}

// The room, or without its held-out stations. Its distances are not used.
Room room_to_estimate(const DepthOptions& options) {
  Room room = Room::open_rays(options.room);
  if (options.hold_out == 0) {
    require_distances_replaceable(options.room);
    return room;
  }
  if (options.hold_out < 2)
    throw UsageError("--hold-out: give 2 or more, or 0 to use all stations");
  if (options.compare_truth) {
    throw UsageError("--truth compares the distances of all stations; give it without --hold-out");
  }
  return room.subset(
      stations_except(room.grid(), held_out_stations(room.grid(), options.hold_out)));
}

// The output directory for maps and summary.
fs::path output_of(const DepthOptions& options) {
  if (options.hold_out == 0) return options.room;
  fs::path output = held_out_directory(options.room);
  make_directories(output);
  return output;
}

// Throws UsageError if the method does not support the options or the room.
void require_method(const Room& room, const DepthOptions& options) {
  if (options.method == DepthMethod::kFlow && room.masked()) {
    throw UsageError(fmt::format(
        "{}: its frames have masks, which optical flow does not support; use --method sweep",
        options.room.string()));
  }
}

cv::Mat read_valid_mask(const DepthOptions& options, PanoramaSize size) {
  if (!options.valid_mask) return {};
  if (options.method == DepthMethod::kFlow) {
    throw UsageError("--valid-mask: optical flow does not support masks; use --method sweep");
  }
  return read_mask(*options.valid_mask, size);
}

InverseDistanceMap final_map(const PartialMaps& partial, const DepthPlan& plan,
                             const SweepReference& reference) {
  return partial.load_stored(kFinalStage, reference.station, reference.position_m, plan.size);
}

MapSummary summary_of(const Room& room, const DepthPlan& plan, const InverseDistanceMap& map) {
  const Line& line = room.grid().lines[static_cast<size_t>(map.station.line)];
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
    if (map.omega[p] * plan.pixels_per_omega_m() >= 1.0) summary.parallax_share += weight;
  }
  summary.mean_confidence /= total;
  summary.low_share /= total;
  summary.parallax_share /= total;
  return summary;
}

// The map in the middle of each line; of many lines, some all over the room.
std::vector<InverseDistanceMap> maps_to_show(const DepthPlan& plan, const PartialMaps& partial) {
  constexpr int kMostLines = 12;
  std::vector<const SweepReference*> middles;
  for (auto begin = plan.maps.begin(); begin != plan.maps.end();) {
    const int line = begin->station.line;
    const auto end = std::find_if(begin, plan.maps.end(), [&](const SweepReference& map) {
      return map.station.line != line;
    });
    middles.push_back(&*(begin + (end - begin) / 2));
    begin = end;
  }
  std::vector<InverseDistanceMap> shown;
  for (const int i : pick_evenly(static_cast<int>(middles.size()), kMostLines)) {
    shown.push_back(final_map(partial, plan, *middles[static_cast<size_t>(i)]));
  }
  return shown;
}

// Outlier frames: at a wrong position, or showing something that moved.
std::vector<StationIndex> outlier_frames(const FrameChecks& checks) {
  std::vector<StationIndex> stations;
  for (const FrameFinding& finding : checks.frames) {
    if (finding.fault != FrameFault::kExposureStep) stations.push_back(finding.station);
  }
  return stations;
}

double spread_of(const StationGains& gains) {
  double square = 0.0;
  int count = 0;
  for (const auto& line : gains.gain) {
    for (const ColourGain& gain : line) {
      const double log_gain = std::log((gain[0] + gain[1] + gain[2]) / 3.0);
      square += log_gain * log_gain;
      ++count;
    }
  }
  return std::sqrt(square / std::max(1, count));
}

// The largest exposure step between neighbours on a line, as a factor.
double largest_step_of(const StationGains& gains) {
  double largest = 0.0;
  for (const auto& line : gains.gain) {
    for (int i = 1; i < static_cast<int>(line.size()); ++i) {
      const double step = log_exposure_step(line, i);
      if (std::fabs(step) > std::fabs(largest)) largest = step;
    }
  }
  return std::exp(largest);
}

void warn(const std::vector<std::string>& warnings, DepthSummary* summary) {
  for (const std::string& warning : warnings) spdlog::warn("{}", warning);
  summary->warnings.insert(summary->warnings.end(), warnings.begin(), warnings.end());
}

void flow_maps(const Room& room, const DepthPlan& plan, const StationGains& gains,
               PartialMaps* partial) {
  Progress progress("following the flow", static_cast<std::int64_t>(plan.maps.size()), "maps");
  for (const SweepReference& reference : plan.maps) {
    throw_if_interrupted();
    if (!partial->load(kFinalStage, reference.station, reference.position_m, plan.size)) {
      partial->store(kFinalStage,
                     flow_map(room, reference.station, plan.reach_m, plan.size, gains.gain));
    }
    progress.advance();
  }
}

// The stations' gains by what the coarse maps show, which agree locally too.
GainFields gains_for_matching(const Room& room, const DepthPlan& plan, const StationGains& gains,
                              const cv::Mat& valid, const PartialMaps& partial) {
  const PanoramaSize size = coarse_size(plan);
  std::map<StationIndex, Eigen::Vector3d> position_m;
  SurfaceMaps maps{size,
                   {},
                   [&](StationIndex station) {
                     return partial.load_stored(kCoarseStage, station, position_m.at(station),
                                                size);
                   },
                   valid};
  for (const SweepReference& map : plan.maps) {
    maps.stations.push_back(map.station);
    position_m.emplace(map.station, map.position_m);
  }
  std::vector<StationIndex> stations = maps.stations;
  for (const SweepCandidate& candidate : plan.candidates) stations.push_back(candidate.station);
  std::sort(stations.begin(), stations.end());
  stations.erase(std::unique(stations.begin(), stations.end()), stations.end());
  return solve_room_gains(room, stations, maps, whole_fields(gains));
}

// Makes the final maps and records statistics in `summary`. Returns the gains of the stations.
GainFields make_maps(const Room& room, DepthMethod method, const DepthPlan& plan,
                     const StationGains& gains, const cv::Mat& valid, PartialMaps* partial,
                     DepthSummary* summary) {
  if (method == DepthMethod::kFlow) {
    flow_maps(room, plan, gains, partial);
    return whole_fields(gains);
  }
  const double max_per_m = find_nearest_surfaces(room, plan, whole_fields(gains), valid, partial);
  summary->nearest_m = 1.0 / max_per_m;
  summary->layers = sweep_layers(max_per_m, plan.reach_m, plan.size).count;
  GainFields fields = gains_for_matching(room, plan, gains, valid, *partial);
  sweep_maps(room, plan, max_per_m, fields, valid, partial);
  fuse_swept_maps(room, plan, fields, partial);
  return fields;
}

// What views leave out, recorded in `summary`.
Contradictions what_moved(const Room& room, const DepthOptions& options, const DepthPlan& plan,
                          const std::vector<std::vector<GainField>>& gains,
                          const PartialMaps& partial, DepthSummary* summary) {
  if (!options.leave_out_moving) return {plan.size, {}};
  Contradictions moved = find_contradictions(
      room, plan, gains,
      [&](const SweepReference& reference) { return final_map(partial, plan, reference); });
  for (const ContradictedStation& found : moved.stations) {
    const Line& line = room.grid().lines[static_cast<size_t>(found.station.line)];
    summary->left_out.push_back({line.id, found.station.station,
                                 line.stations[static_cast<size_t>(found.station.station)].file,
                                 found.share});
  }
  return moved;
}

struct ExaminedFrames {
  StationGains gains;
  std::vector<StationIndex> outliers;
};

// Checks the frames, warns about outliers and removes them from the plan.
ExaminedFrames examine_frames(const Room& room, DepthPlan* plan, DepthSummary* summary) {
  const std::vector<StationLink> links = measure_links(room, pairs_to_compare(room.grid()));
  StationGains gains = solve_gains(room.grid(), links);
  const FrameChecks checks = check_frames(room, links, gains, plan->reach_m);
  summary->gain_spread = spread_of(gains);
  summary->largest_exposure_step = largest_step_of(gains);
  summary->frame_findings = checks.frames;
  warn(warnings_of(room, checks), summary);
  ExaminedFrames examined{std::move(gains), outlier_frames(checks)};
  exclude_stations(examined.outliers, plan);
  return examined;
}

// The plan for a room without cells, whose lines do not tell how far away the scene is.
DepthPlan plan_by_surfaces(const Room& room, const DepthOptions& options, const DepthPlan& plan,
                           const ExaminedFrames& frames, const cv::Mat& valid) {
  const double surfaces_m = near_distance_m(room, plan, whole_fields(frames.gains), valid);
  DepthPlan near = plan_depth(room, options, surfaces_m);
  exclude_stations(frames.outliers, &near);
  return near;
}

int stations_of(const Grid& grid) {
  std::size_t count = 0;
  for (const Line& line : grid.lines) count += line.stations.size();
  return static_cast<int>(count);
}

// Throws Error if there are no given distances.
GivenDistances truth_of(const DepthOptions& options) {
  GivenDistances given(Room::open_rays(options.room));
  if (!given.empty()) return given;
  throw Error(
      fmt::format("{}: --truth: no distances were packed with the room; pack it with --distance",
                  options.room.string()));
}

// Puts the finished volumes where they are used.
void install(const DepthOptions& options, PartialMaps* partial) {
  if (options.hold_out > 0) {
    partial->complete("");
    return;
  }
  replace_estimated(options.room, partial->volumes(),
                    [&](const std::string& keep_as) { partial->complete(keep_as); });
}

void set_use(const fs::path& room, DepthSummary* summary) {
  const RoomDistances distances = find_distances(room, read_manifest(room));
  const FoundDistances* in_use = distances.in_use();
  summary->distances = in_use == nullptr ? "none" : in_use->set.origin;
  if (distances.given && !distances.given->in_use) {
    summary->kept_given = distances.given->directory.string();
  }
}

}  // namespace

DepthSummary estimate_depth(const DepthOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const Room room = room_to_estimate(options);
  require_method(room, options);
  DepthPlan plan = plan_depth(room, options);
  const cv::Mat valid = read_valid_mask(options, plan.size);
  std::optional<GivenDistances> truth;
  if (options.compare_truth) truth = truth_of(options);
  DepthSummary summary{.room = options.room.string(),
                       .method = name_of(options.method),
                       .size = plan.size,
                       .stations = stations_of(room.grid()),
                       .every = options.every,
                       .hold_out = options.hold_out,
                       .valid_mask = options.valid_mask.value_or(fs::path()).string(),
                       .leave_out_moving = options.leave_out_moving};
  const ExaminedFrames frames = examine_frames(room, &plan, &summary);
  if (room.grid().cells.empty() && options.method == DepthMethod::kSweep) {
    plan = plan_by_surfaces(room, options, plan, frames, valid);
  }
  summary.reach_m = plan.reach_m;
  const fs::path output = output_of(options);
  PartialMaps partial(output, fingerprint_of(room, options, plan));
  const auto fields =
      make_maps(room, options.method, plan, frames.gains, valid, &partial, &summary);
  for (const SweepReference& reference : plan.maps) {
    summary.maps.push_back(summary_of(room, plan, final_map(partial, plan, reference)));
  }
  warn(parallax_warnings(summary.maps, plan.pixels_per_omega_m()), &summary);
  if (truth) summary.truth = compare_with_truth(*truth, plan, partial);
  const std::vector<InverseDistanceMap> shown = maps_to_show(plan, partial);
  const Contradictions moved = what_moved(room, options, plan, fields, partial, &summary);
  write_volumes(room, options.method, plan, partial, moved);
  install(options, &partial);
  set_use(options.room, &summary);
  if (options.gains && options.hold_out == 0) summary.gains = make_gains(options.room);
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary.peak_memory_mb = peak_memory_mb();
  summary.page = (output / "depth.html").string();
  const nlohmann::ordered_json document = depth_document(summary);
  write_file_atomically(output / "depth.json", json_text(document));
  write_file_atomically(output / "depth.html", depth_page(document, map_pictures(room, shown)));
  return summary;
}

}  // namespace raywalk::build_lf
