// Estimates distances from the panoramas: `raywalk-build-lf depth`.
#pragma once

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_summary.h"

namespace raywalk::build_lf {

// Estimates distance maps, stores them in ROOM/distances, where views use them, and records them in
// the manifest, with ROOM/depth.json and a report beside it. Distances packed with the room are
// moved to ROOM/distances-given. With
// options.hold_out all output goes to ROOM/held-out instead. A stopped run (Interrupted, disk full)
// keeps its finished maps in ROOM/distances.partial, and the same command resumes it. Throws
// UsageError for contradictory options; Error as plan_depth and PartialMaps do, for a mask or truth
// that does not match the room, and for output that cannot be written.
DepthSummary estimate_depth(const DepthOptions& options);

}  // namespace raywalk::build_lf
