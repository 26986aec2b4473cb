// rectify.json.
#pragma once

#include <filesystem>

#include "calibrate/base/capture_set.h"
#include "calibrate/rectify/rectify_set.h"

namespace raywalk::calibrate {

// Writes it into OUT. Throws Error if it cannot be written.
void write_rectify_report(const CaptureSet& set, const FramePoses& poses,
                          const RectifyResult& result, const std::filesystem::path& out);

}  // namespace raywalk::calibrate
