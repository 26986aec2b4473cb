#include "build_lf/depth/estimate_depth.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "build_lf/depth/depth_truth.h"
#include "build_lf/depth/finish_maps.h"
#include "build_lf/depth/flow_depth.h"
#include "build_lf/depth/map_images.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/depth/plane_sweep.h"
#include "build_lf/depth/preparation.h"
#include "build_lf/depth/sweep_depth.h"
#include "build_lf/exposure/make_gains.h"
#include "build_lf/pack/distance_sets.h"
#include "build_lf/pack/pack_room.h"
#include "core/base/error.h"
#include "core/base/pick_evenly.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
#include "core/files/json.h"
#include "core/room/kept_stations.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// Increment when the estimation changes: maps of another version are not resumed.
constexpr int kEstimatorVersion = 7;

// Over everything that determines the maps.
std::string fingerprint_of(const Room& room, const DepthOptions& options, PanoramaSize size) {
  std::string text = fmt::format("{} {} {}x{} {}\n", kEstimatorVersion, name_of(options.method),
                                 size.width, size.height, options.every);
  for (const Line& line : room.grid().lines) {
    text += checksum_of_line(line_volume_path(room.directory(), line.id)) + "\n";
  }
  RoomManifest manifest = room.manifest();
  manifest.distances = DistanceKind::kNone;  // they are not used, and a run changes them
  manifest.gains = false;                    // the same
  text += manifest_to_json(manifest);        // station positions
  if (options.valid_mask) text += read_file(*options.valid_mask);
  return sha256_hex(text);
}

// Throws UsageError if the method does not support the options or the room.
void require_method(const Room& room, const DepthOptions& options) {
  if (options.method == DepthMethod::kFlow && room.masked()) {
    throw UsageError(fmt::format(
        "{}: its frames have masks, which optical flow does not support; use --method sweep",
        options.room.string()));
  }
}

// The room, or without its held-out stations. Its distances are not used.
Room room_to_estimate(const DepthOptions& options) {
  Room room = Room::open_rays(options.room);
  require_method(room, options);
  if (options.hold_out == 0) return room;
  if (options.hold_out < 2)
    throw UsageError("--hold-out: give 2 or more, or 0 to use all stations");
  if (options.compare_truth) {
    throw UsageError("--truth compares the distances of all stations; give it without --hold-out");
  }
  return room.subset(
      stations_except(room.grid(), held_out_stations(room.grid(), options.hold_out)));
}

fs::path output_of(const DepthOptions& options) {
  if (options.hold_out == 0) return options.room;
  fs::path output = held_out_directory(options.room);
  make_directories(output);
  return output;
}

cv::Mat read_valid_mask(const DepthOptions& options, PanoramaSize size) {
  if (!options.valid_mask) return {};
  if (options.method == DepthMethod::kFlow) {
    throw UsageError("--valid-mask: optical flow does not support masks; use --method sweep");
  }
  return read_mask(*options.valid_mask, size);
}

double peak_memory_mb() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

// The map in the middle of each line; of many lines, some all over the room.
std::vector<InverseDistanceMap> maps_to_show(const DepthPlan& plan, const PartialMaps& partial) {
  constexpr int kMostLines = 12;
  const std::vector<SweepReference>& maps = plan.maps;
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
    shown.push_back(partial.stored(kFinalStage, middles[static_cast<size_t>(i)]->station));
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

// A run, whose maps are kept in the room's working directory until the room has its distances.
class DepthRun {
 public:
  // Opens the room and its working directory. Throws UsageError for options that contradict each
  // other, Error as Room::open_rays and PartialMaps do. The maps are the same with what moved and
  // without; the volumes are not.
  DepthRun(const DepthOptions& options, MapsUse use)
      : options_(options),
        room_(room_to_estimate(options)),
        size_(plan_depth(room_, options).size),
        valid_(read_valid_mask(options, size_)),
        output_(output_of(options)),
        partial_(output_, fingerprint_of(room_, options, size_), use,
                 options.leave_out_moving ? "volumes" : "volumes-of-all") {}

  bool has(DepthStep step) const {
    const bool only_of_sweep = step == DepthStep::kChoose || step == DepthStep::kFuse;
    return !only_of_sweep || options_.method == DepthMethod::kSweep;
  }

  // Does a part of a step: what of it is not done. Throws Error if anything of the steps before is
  // missing, and as the steps do; Interrupted.
  void make(DepthStep step, WorkPart part) {
    if (step == DepthStep::kPrepare) {
      prepared_ = kept_preparation(room_, options_, partial_);
      if (prepared_) {
        warn_of(room_, prepared_->checks);
      } else {
        prepared_ = prepare_depth(room_, options_, valid_, &partial_);
      }
      return;
    }
    const Preparation& known = prepared();
    const IndexRange share = part.share_of(known.plan.maps.size());
    switch (step) {
      case DepthStep::kPrepare:
        return;
      case DepthStep::kSweep:
        if (options_.method == DepthMethod::kFlow) return make_flow_maps(share);
        return sweep_maps(room_, known.plan, known.nearest_per_m, known.gains, valid_, share,
                          &partial_);
      case DepthStep::kChoose:
        require_maps(DepthStep::kSweep);
        return choose_maps(room_, known.plan, known.gains, valid_, share, &partial_);
      case DepthStep::kFuse:
        require_maps(DepthStep::kChoose);
        return fuse_chosen_maps(room_, known.plan, known.gains, share, &partial_);
      case DepthStep::kVolumes:
        require_maps(has(DepthStep::kFuse) ? DepthStep::kFuse : DepthStep::kSweep);
        return make_volumes(part.share_of(room_.grid().lines.size()));
    }
  }

  // Puts the finished volumes where they are used, and reports.
  DepthSummary finish(const std::optional<GivenDistances>& truth,
                      std::chrono::steady_clock::time_point start) {
    DepthSummary summary = collected();
    if (truth) summary.truth = compare_with_truth(*truth, plan(), partial_);
    const std::vector<InverseDistanceMap> shown = maps_to_show(plan(), partial_);
    partial_.complete();
    if (options_.hold_out == 0) use_distances(options_.room, DistanceKind::kEstimated);
    set_use(options_.room, &summary);
    if (options_.gains && options_.hold_out == 0) {
      replace_gains(options_.room, prepared().gains);
      summary.gains = summary_of(prepared().gains);
    }
    summary.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    summary.peak_memory_mb = peak_memory_mb();
    summary.page = (output_ / "depth.html").string();
    const nlohmann::ordered_json document = depth_document(summary);
    write_file_atomically(output_ / "depth.json", json_text(document));
    write_file_atomically(output_ / "depth.html",
                          report_page("depth", document, map_images(room_, shown)));
    return summary;
  }

 private:
  // What the complete steps found.
  DepthSummary collected() {
    const FrameChecks& checks = prepared().checks;
    const Grid& grid = room_.grid();
    DepthSummary summary{
        .room = options_.room.string(),
        .method = name_of(options_.method),
        .size = plan().size,
        .stations = static_cast<int>(all_stations(grid).size()),
        .every = options_.every,
        .hold_out = options_.hold_out,
        .valid_mask = options_.valid_mask.value_or(fs::path()).string(),
        .reach_m = plan().reach_m,
        .largest_exposure_step = checks.largest_exposure_step,
        .maps = map_summaries(grid, plan(), partial_),
        .leave_out_moving = options_.leave_out_moving,
        .left_out = left_out_summaries(grid, open_distance_volumes(partial_.volumes(), grid)),
        .frame_findings = checks.frames};
    if (options_.method == DepthMethod::kSweep) {
      const double max_per_m = prepared().nearest_per_m;
      summary.nearest_m = 1.0 / max_per_m;
      summary.layers = sweep_layers(max_per_m, summary.reach_m, summary.size).count;
    }
    summary.warnings = warnings_of(room_, checks);
    const auto parallax = parallax_warnings(summary.maps, plan().pixels_per_inverse_m());
    for (const std::string& warning : parallax) {
      spdlog::warn("{}", warning);
      summary.warnings.push_back(warning);
    }
    return summary;
  }

  // The stage of a step's maps; null: it has none.
  const char* stage_of(DepthStep step) const {
    switch (step) {
      case DepthStep::kSweep:
        return options_.method == DepthMethod::kFlow ? kFinalStage : kSweptStage;
      case DepthStep::kChoose:
        return kChosenStage;
      case DepthStep::kFuse:
        return kFinalStage;
      default:
        return nullptr;
    }
  }

  // Throws Error if the first step has not been done.
  const Preparation& prepared() {
    if (!prepared_) prepared_ = kept_preparation(room_, options_, partial_);
    if (!prepared_) {
      throw Error(fmt::format("{}: do step prepare first", options_.room.string()));
    }
    return *prepared_;
  }

  const DepthPlan& plan() { return prepared().plan; }

  void require_maps(DepthStep step) {
    if (!has(step)) return;
    const auto missing = std::ranges::count_if(plan().maps, [&](const SweepReference& map) {
      return !partial_.has(stage_of(step), map.station);
    });
    if (missing == 0) return;
    throw Error(fmt::format("{}: step {} has to be done first: {} of its {} maps are missing",
                            options_.room.string(), name_of(step), missing, plan().maps.size()));
  }

  void make_flow_maps(IndexRange share) {
    make_maps(plan(), share, kFinalStage, "following the flow", &partial_, [&](int i) {
      return flow_map(room_, plan().station_of(i), plan().reach_m, size_, prepared().gains);
    });
  }

  void make_volumes(IndexRange lines) {
    LineSearch search = [](int) { return Contradictions(); };
    if (options_.leave_out_moving) {
      search = contradiction_search(room_, plan(), prepared().gains, [&](StationIndex station) {
        return partial_.stored(kFinalStage, station);
      });
    }
    write_volumes(room_, options_.method, plan(), partial_, lines, search);
  }

  DepthOptions options_;
  Room room_;          // without held-out stations
  PanoramaSize size_;  // of the maps
  cv::Mat valid_;
  fs::path output_;  // for maps and summary
  PartialMaps partial_;
  std::optional<Preparation> prepared_{};
};

}  // namespace

std::string name_of(DepthStep step) {
  constexpr std::array<const char*, kDepthSteps.size()> kNames{"prepare", "sweep", "choose", "fuse",
                                                               "volumes"};
  return kNames.at(static_cast<std::size_t>(step));
}

std::string depth_step_names() {
  std::string names;
  for (const DepthStep step : kDepthSteps) names += (names.empty() ? "" : ", ") + name_of(step);
  return names;
}

DepthStep depth_step_from_name(const std::string& name) {
  for (const DepthStep step : kDepthSteps) {
    if (name == name_of(step)) return step;
  }
  throw UsageError(
      fmt::format("unknown step {}; the steps are {}", excerpt(name), depth_step_names()));
}

DepthSummary estimate_depth(const DepthOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  DepthRun run(options, MapsUse::kAlone);
  std::optional<GivenDistances> truth;
  if (options.compare_truth) truth = truth_of(options);
  for (const DepthStep step : kDepthSteps) {
    if (run.has(step)) run.make(step, {});
  }
  return run.finish(truth, start);
}

std::string estimate_step(const DepthOptions& options, DepthStep step, WorkPart part) {
  const bool alone = step == DepthStep::kPrepare;
  if (alone && part.count > 1) throw UsageError("--part: step prepare is done in one piece");
  DepthRun run(options, alone ? MapsUse::kAlone : MapsUse::kShared);
  const std::string name = fmt::format("{}: step {}", options.room.string(), name_of(step));
  if (!run.has(step)) return name + ": this run has no such step";
  run.make(step, part);
  if (part.count == 1) return name + " is done";
  return fmt::format("{}, part {}/{} is done", name, part.index, part.count);
}

}  // namespace raywalk::build_lf
