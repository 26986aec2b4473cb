// Estimates distances from the panoramas: `raywalk-build-lf depth`.
#pragma once

#include <string>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_steps.h"
#include "build_lf/depth/depth_summary.h"
#include "core/base/block.h"

namespace raywalk::build_lf {

// Estimates distance maps, stores them in ROOM/distances, where views use them, and records them in
// the manifest, with ROOM/depth.json and a report beside it. Distances packed with the room are
// moved to ROOM/distances-given. With
// options.hold_out all output goes to ROOM/held-out instead. A stopped run (Interrupted, disk full)
// keeps its finished maps in ROOM/distances.partial, and the same command resumes it. Throws
// UsageError for contradictory options; Error as plan_depth and PartialMaps do, for a mask or truth
// that does not match the room, and for output that cannot be written.
DepthSummary estimate_depth(const DepthOptions& options);

// Does a block of a step, which processes on any machines can do at once; what is done is not done
// again. Returns a sentence for the terminal. Throws Error if what it needs of the steps before is
// missing, and if the blocks that are there are of other options or of the room as it was.
std::string estimate_block(const DepthOptions& options, DepthStep step, Block block);

// Does what a step leaves to one process, once all of its blocks are done. The first that needs it
// does it otherwise. Throws Error naming the blocks that are missing.
std::string merge_step(const DepthOptions& options, DepthStep step);

// Finishes what blocks did, with the result of estimate_depth(). Throws Error naming the blocks of
// every step that are missing.
DepthSummary merge_depth(const DepthOptions& options);

}  // namespace raywalk::build_lf
