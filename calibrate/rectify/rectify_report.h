// rectify.json, with the exposures: what was measured, how surely, and what was corrected.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "calibrate/base/capture_set.h"
#include "calibrate/rectify/exposure_gains.h"
#include "calibrate/rectify/rectify_set.h"

namespace raywalk::calibrate {

// Writes it into OUT. Throws Error if it cannot be written.
void write_rectify_report(const CaptureSet& set, const FramePoses& poses,
                          const RectifyResult& result, const std::filesystem::path& out);

// Its document.
nlohmann::ordered_json rectify_document(const CaptureSet& set, const FramePoses& poses,
                                        const RectifyResult& result,
                                        const std::filesystem::path& out);

// "exposures differ from frame to frame; 30 of 36 frames are corrected", in one sentence.
std::string exposure_summary(const ExposureResult& exposure);

}  // namespace raywalk::calibrate
