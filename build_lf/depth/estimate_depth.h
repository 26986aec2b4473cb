// Estimates distances from the panoramas: `raywalk-build-lf depth`.
#pragma once

#include <array>
#include <string>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_summary.h"
#include "build_lf/pack/work_part.h"

namespace raywalk::build_lf {

// The steps of a run. It does not matter which process does them: parts of a step, on any machines,
// leave the maps (PartialMaps) that a run of its own would make, and that run makes what is
// missing. In this order: each needs all of those before it.
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

// Estimates distance maps, stores them in ROOM/distances, where views use them, and records them in
// the manifest, with ROOM/depth.json and a report beside it. Distances packed with the room are
// moved to ROOM/distances-given. With
// options.hold_out all output goes to ROOM/held-out instead. A stopped run (Interrupted, disk full)
// keeps its finished maps in ROOM/distances.partial, and the same command resumes it. Throws
// UsageError for contradictory options; Error as plan_depth and PartialMaps do, for a mask or truth
// that does not match the room, and for output that cannot be written.
DepthSummary estimate_depth(const DepthOptions& options);

// Does a step, or a part of it (not of kPrepare), which processes on any machines can do at once;
// what is done is not done again. estimate_depth() then makes what is missing and finishes. Returns
// a sentence for the terminal. Throws Error if anything of the steps before is missing, and if the
// maps that are there are of other options or of the room as it was.
std::string estimate_step(const DepthOptions& options, DepthStep step, WorkPart part);

}  // namespace raywalk::build_lf
