// The poses of held-out frames in an estimated grid. They have no part in the estimate.
#pragma once

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/grid/grid_result.h"

namespace raywalk::calibrate {

// By held-out frame of the set, in order: its solved pose, moved and turned as the grid moved and
// turned the solved poses of the stations, the nearer ones counting more; nullopt without a solved
// pose, or if no station has one. `solved` is by frame; `result` is the estimate of the stations.
FramePoses held_out_poses(const CaptureSet& set, const FramePoses& solved,
                          const GridResult& result);

}  // namespace raywalk::calibrate
