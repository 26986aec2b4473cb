#include "build_lf/depth/depth_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "build_lf/depth/depth_steps.h"
#include "build_lf/depth/finish_maps.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/depth/station_links.h"
#include "build_lf/depth/sweep_depth.h"
#include "build_lf/distance_sets.h"
#include "build_lf/gains/make_gains.h"
#include "build_lf/gains/room_gains.h"
#include "build_lf/pack_room.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/sha256.h"
#include "core/room/kept_stations.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// Increment when the estimation changes: maps of another version are not resumed.
constexpr int kEstimatorVersion = 6;

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

std::vector<StationIndex> outlier_frames(const FrameChecks& checks) {
  std::vector<StationIndex> stations;
  for (const FrameFinding& finding : checks.frames) {
    if (finding.fault != FrameFault::kExposureStep) stations.push_back(finding.station);
  }
  return stations;
}

}  // namespace

DepthWork::DepthWork(const DepthOptions& options, MapsUse use)
    : options_(options),
      room_(room_to_estimate(options)),
      first_plan_(plan_depth(room_, options)),
      valid_(read_valid_mask(options, first_plan_.size)),
      output_(output_of(options)),
      partial_(output_, fingerprint_of(room_, options, first_plan_.size), use) {}

bool DepthWork::has(DepthStep step) const {
  const bool sweep = options_.method == DepthMethod::kSweep;
  switch (step) {
    case DepthStep::kReach:
      return sweep && room_.grid().cells.empty();
    case DepthStep::kChoose:
    case DepthStep::kFuse:
      return sweep;
    case DepthStep::kMoved:
      return options_.leave_out_moving;
    case DepthStep::kGains:
      return options_.gains && options_.hold_out == 0;
    default:
      return true;
  }
}

BlockResults DepthWork::results(DepthStep step) {
  // The maps are the same with what moved and without; what is made of them is not.
  const bool of_moved = step == DepthStep::kVolumes || step == DepthStep::kGains;
  const std::string inputs =
      sha256_hex(of_moved && !options_.leave_out_moving ? "all" : "left out");
  return {partial_.results(), name_of(step), inputs,
          [this, step](Block block) { return stores_all_maps(step, block); }};
}

bool DepthWork::stores_all_maps(DepthStep step, Block block) {
  const auto all_of = [&](const char* stage) {
    const IndexRange share = block.share_of(plan().maps.size());
    return std::all_of(plan().maps.begin() + static_cast<std::ptrdiff_t>(share.begin),
                       plan().maps.begin() + static_cast<std::ptrdiff_t>(share.end),
                       [&](const SweepReference& map) { return partial_.has(stage, map.station); });
  };
  const bool flow = options_.method == DepthMethod::kFlow;
  if (step == DepthStep::kSurfaces) return all_of(kCoarseStage);
  if (step == DepthStep::kSweep) return all_of(flow ? kFinalStage : kSweptStage);
  if (step == DepthStep::kChoose) return all_of(kChosenStage);
  if (step == DepthStep::kFuse) return all_of(kFinalStage);
  return true;
}

bool DepthWork::make(DepthStep step, Block block) {
  return results(step).make(block, [&] { return run(step, block); });
}

void DepthWork::complete(DepthStep step) {
  const BlockResults of_step = results(step);
  if (of_step.complete_count()) return;
  const bool compares = step == DepthStep::kColours || step == DepthStep::kGains;
  const int count = of_step.count_to_complete(compares ? parts_of(pieces(step)) : 1);
  for (int index = 1; index <= count; ++index) make(step, {index, count});
}

std::string DepthWork::missing(DepthStep step) {
  return has(step) ? results(step).missing() : std::string();
}

void DepthWork::require(DepthStep step) {
  const std::string blocks = missing(step);
  if (blocks.empty()) return;
  throw Error(fmt::format("{}: step {}: {}; make them with --step {} --block",
                          partial_.results().parent_path().string(), name_of(step), blocks,
                          name_of(step)));
}

std::vector<std::string> DepthWork::merged(DepthStep step) {
  require(step);
  return results(step).merged();
}

const ExaminedFrames& DepthWork::frames() {
  if (frames_) return *frames_;
  std::vector<StationLink> links;
  for (const std::string& bytes : merged(DepthStep::kLinks)) {
    const std::vector<StationLink> of_block = links_of(bytes);
    links.insert(links.end(), of_block.begin(), of_block.end());
  }
  ExaminedFrames frames{check_frames(room_, links, first_plan_.reach_m), {}};
  frames.outliers = outlier_frames(frames.checks);
  frames_ = std::move(frames);
  return *frames_;
}

const DepthPlan& DepthWork::plan_before_reach() {
  if (plan_before_reach_) return *plan_before_reach_;
  DepthPlan plan = first_plan_;
  exclude_stations(frames().outliers, &plan);
  plan_before_reach_ = std::move(plan);
  return *plan_before_reach_;
}

const DepthPlan& DepthWork::plan() {
  if (plan_) return *plan_;
  DepthPlan plan = plan_before_reach();
  if (has(DepthStep::kReach)) {
    // Without cells, the lines do not tell how far away the scene is.
    const OmegaHistogram near = sum_of_histograms(plan, merged(DepthStep::kReach));
    plan = plan_depth(room_, options_, near_distance_m(plan, near));
    exclude_stations(frames().outliers, &plan);
  }
  plan_ = std::move(plan);
  return *plan_;
}

double DepthWork::nearest_per_m() {
  if (!nearest_per_m_) {
    nearest_per_m_ =
        nearest_surfaces_per_m(plan(), sum_of_histograms(plan(), merged(DepthStep::kSurfaces)));
  }
  return *nearest_per_m_;
}

const GainFields& DepthWork::matching_gains() {
  if (matching_gains_) return *matching_gains_;
  const BlockResults solved(partial_.results(), "solved-colours", "");
  const Block all;
  if (!solved.done(all)) {
    // The first does it for all: it takes time and memory.
    require(DepthStep::kColours);
    const FileLock lock(partial_.results() / "solving.lock", "", FileLock::Use::kAwaited);
    solved.make(all, [&] {
      return bytes_of(
          solve_room_gains(room_, all_stations(room_.grid()), ratios(DepthStep::kColours)));
    });
  }
  matching_gains_ = gain_fields_of(solved.result_of(all));
  return *matching_gains_;
}

std::vector<MapSummary> DepthWork::map_summaries() {
  std::vector<MapSummary> all;
  const bool flow = options_.method == DepthMethod::kFlow;
  for (const std::string& bytes : merged(flow ? DepthStep::kSweep : DepthStep::kFuse)) {
    std::ranges::move(map_summaries_of(bytes), std::back_inserter(all));
  }
  return all;
}

std::vector<LeftOutSummary> DepthWork::left_out() {
  std::vector<LeftOutSummary> all;
  if (!has(DepthStep::kMoved)) return all;
  require(DepthStep::kMoved);
  const BlockResults moved = results(DepthStep::kMoved);
  const int count = moved.complete_count().value();
  for (int index = 1; index <= count; ++index) {  // one after the other, as they can be large
    for (const auto& found : contradicted_stations_of(moved.result_of({index, count}))) {
      const Line& line = room_.grid().lines[static_cast<size_t>(found.station.line)];
      all.push_back({line.id, found.station.station,
                     line.stations[static_cast<size_t>(found.station.station)].file, found.share});
    }
  }
  return all;
}

GainFields DepthWork::room_gains() {
  return solve_room_gains(room_, all_stations(room_.grid()), ratios(DepthStep::kGains));
}

RatioParts DepthWork::ratios(DepthStep step) {
  require(step);
  const int count = results(step).complete_count().value();
  return {count, [of_step = results(step), count](int part) {
            return ratios_of(of_step.result_of({part + 1, count}));
          }};
}

InverseDistanceMap DepthWork::final_map(const SweepReference& reference) const {
  return partial_.load_stored(kFinalStage, reference.station, reference.position_m,
                              first_plan_.size);
}

void DepthWork::install() {
  require(DepthStep::kVolumes);
  // An interrupted move leaves the volumes that it replaces where the new ones were.
  results(DepthStep::kVolumes).remove();
  partial_.complete();
  if (options_.hold_out == 0) use_distances(options_.room, DistanceKind::kEstimated);
}

}  // namespace raywalk::build_lf
