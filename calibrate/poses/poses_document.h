// poses.json: what solving the poses gave, for the next steps and the report.
#pragma once

#include <filesystem>

#include "calibrate/base/capture_set.h"
#include "calibrate/poses/solve_poses.h"

namespace raywalk::calibrate {

// Writes the result as JSON (docs/file-formats.md). Throws Error if it cannot be written.
void write_poses(const std::filesystem::path& file, const CaptureSet& set,
                 const PosesResult& result);

}  // namespace raywalk::calibrate
