// Distances from what was captured: `raywalk-build-lf depth`.
#pragma once

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_summary.h"

namespace raywalk::build_lf {

// Estimates distance maps and stores them in ROOM/distances, with ROOM/depth.json and a page beside
// it. Distances that were packed with the room are kept in ROOM/distances-given. With
// options.hold_out all of this is made in ROOM/held-out instead. A run that was
// stopped (Interrupted, disk full) keeps its finished maps in ROOM/distances.partial; the same
// command resumes there. Throws UsageError for options that contradict each other; Error: what
// plan_depth and PartialMaps refuse, a mask or truth that does not fit, output that cannot be
// written.
DepthSummary estimate_depth(const DepthOptions& options);

}  // namespace raywalk::build_lf
