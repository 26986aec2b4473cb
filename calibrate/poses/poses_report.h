// The report of solved poses, as HTML and JSON.
#pragma once

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/solve_poses.h"

namespace raywalk::calibrate {

// Writes poses-report.json and poses.html into `out`. `start` are the initial poses of the
// solution. Throws Error if a file cannot be written.
void write_poses_report(const std::filesystem::path& out, const CaptureSet& set,
                        const FramePoses& start, const PosesResult& result);

}  // namespace raywalk::calibrate
