// The report of solved poses, as JSON.
#pragma once

#include <filesystem>

#include "calibrate/base/capture_set.h"
#include "calibrate/poses/solve_poses.h"

namespace raywalk::calibrate {

// Writes poses-report.json into `out`. Throws Error if it cannot be written.
void write_poses_report(const std::filesystem::path& out, const CaptureSet& set,
                        const PosesResult& result);

}  // namespace raywalk::calibrate
