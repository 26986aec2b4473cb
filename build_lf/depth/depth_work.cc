#include "build_lf/depth/depth_work.h"

#include <fmt/format.h>

#include <algorithm>

#include "build_lf/depth/finish_maps.h"
#include "build_lf/depth/flow_depth.h"
#include "build_lf/depth/sweep_depth.h"
#include "build_lf/pack/distance_sets.h"
#include "build_lf/pack/pack_room.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
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

// The maps are the same with what moved and without; the volumes are not.
DepthWork::DepthWork(const DepthOptions& options, MapsUse use)
    : options_(options),
      room_(room_to_estimate(options)),
      size_(plan_depth(room_, options).size),
      valid_(read_valid_mask(options, size_)),
      output_(output_of(options)),
      partial_(output_, fingerprint_of(room_, options, size_), use,
               options.leave_out_moving ? "volumes" : "volumes-of-all") {}

bool DepthWork::has(DepthStep step) const {
  const bool only_of_sweep = step == DepthStep::kChoose || step == DepthStep::kFuse;
  return !only_of_sweep || options_.method == DepthMethod::kSweep;
}

const char* DepthWork::stage_of(DepthStep step) const {
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

const Preparation& DepthWork::prepared() {
  if (!prepared_) prepared_ = kept_preparation(room_, options_, partial_);
  if (!prepared_) {
    throw Error(fmt::format("{}: do step prepare first", options_.room.string()));
  }
  return *prepared_;
}

void DepthWork::require_maps(DepthStep step) {
  if (!has(step)) return;
  const auto missing = std::ranges::count_if(plan().maps, [&](const SweepReference& map) {
    return !partial_.has(stage_of(step), map.station);
  });
  if (missing == 0) return;
  throw Error(fmt::format("{}: step {} has to be done first: {} of its {} maps are missing",
                          options_.room.string(), name_of(step), missing, plan().maps.size()));
}

void DepthWork::make(DepthStep step, WorkPart part) {
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

void DepthWork::make_flow_maps(IndexRange share) {
  make_maps(plan(), share, kFinalStage, "following the flow", &partial_, [&](int i) {
    return flow_map(room_, plan().station_of(i), plan().reach_m, size_, prepared().gains);
  });
}

void DepthWork::make_volumes(IndexRange lines) {
  LineSearch search = [](int) { return Contradictions(); };
  if (options_.leave_out_moving) {
    search = contradiction_search(room_, plan(), prepared().gains,
                                  [&](StationIndex station) { return final_map(station); });
  }
  write_volumes(room_, options_.method, plan(), partial_, lines, search);
}

void DepthWork::install() {
  partial_.complete();
  if (options_.hold_out == 0) use_distances(options_.room, DistanceKind::kEstimated);
}

}  // namespace raywalk::build_lf
