// Estimates distances from the panoramas: `raywalk-build-lf depth`.
#pragma once

#include <string>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/depth_work.h"
#include "build_lf/pack/work_part.h"

namespace raywalk::build_lf {

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
