// The work of a depth run, step by step.
//
// What a step leaves is kept in the room's working directory (PartialMaps) until the room has its
// distances. It does not matter which process made it: parts of a step, on any machines, leave the
// maps that a run of its own would make, and that run makes what is missing.
#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/depth/preparation.h"
#include "build_lf/pack/work_part.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// In this order: each needs all of those before it.
enum class DepthStep {
  kPrepare,  // what is found before the maps, in one piece
  kSweep,    // a map from the pictures of every station; with optical flow the finished map
  kChoose,   // each pixel's surface among those around it
  kFuse,     // the finished maps: neighbours vote
  kVolumes,  // the room's distance volumes, without what single stations show and others contradict
};

inline constexpr std::array kDepthSteps{DepthStep::kPrepare, DepthStep::kSweep, DepthStep::kChoose,
                                        DepthStep::kFuse, DepthStep::kVolumes};

// "prepare", "sweep", ...
std::string name_of(DepthStep step);
// All names in order, with commas between.
std::string depth_step_names();
// Throws UsageError naming all.
DepthStep depth_step_from_name(const std::string& name);

class DepthWork {
 public:
  // Opens the room and its working directory. Throws UsageError for options that contradict each
  // other, Error as Room::open_rays and PartialMaps do, and if estimated distances cannot replace
  // those of the room.
  DepthWork(const DepthOptions& options, MapsUse use);

  const Room& room() const { return room_; }  // without held-out stations
  const DepthOptions& options() const { return options_; }
  const std::filesystem::path& output() const { return output_; }  // for maps and summary
  const PartialMaps& partial() const { return partial_; }

  // Whether the run has the step.
  bool has(DepthStep step) const;
  // Does a part of a step: what of it is not done. Throws Error if anything of the steps before is
  // missing, and as the steps do; Interrupted.
  void make(DepthStep step, WorkPart part);
  // Throws Error if the first step has not been done.
  const Preparation& prepared();
  const DepthPlan& plan() { return prepared().plan; }
  InverseDistanceMap final_map(StationIndex station) const {
    return partial_.stored(kFinalStage, station);
  }
  // Moves the volumes into the room, or to the held-out ones, and removes the working directory.
  void install();

 private:
  // The stage of a step's maps; null: it has none.
  const char* stage_of(DepthStep step) const;
  void require_maps(DepthStep step);
  void make_flow_maps(IndexRange share);
  void make_volumes(IndexRange lines);

  DepthOptions options_;
  Room room_;
  PanoramaSize size_;  // of the maps
  cv::Mat valid_;
  std::filesystem::path output_;
  PartialMaps partial_;
  std::optional<Preparation> prepared_{};
};

}  // namespace raywalk::build_lf
