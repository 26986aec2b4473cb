// The exposures in rectify.json: what was measured, how surely, and what was corrected.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "calibrate/base/capture_set.h"
#include "calibrate/rectify/exposure_gains.h"

namespace raywalk::calibrate {

// "exposures differ from frame to frame; 30 of 36 frames are corrected", in one sentence.
std::string exposure_summary(const ExposureResult& exposure);

// Photographic stops (factors of two), mean of the colours.
double mean_stops(const LightGain& gain);

// The key "exposure" of rectify.json, and that of a frame of it; docs/file-formats.md has the keys.
nlohmann::ordered_json exposure_json(const CaptureSet& set, const ExposureResult& exposure);
nlohmann::ordered_json frame_exposure_json(const ExposureResult& exposure, int frame);

}  // namespace raywalk::calibrate
