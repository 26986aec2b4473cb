// The exposures in rectify.json and rectify.html: what was measured, how surely, and what was
// corrected.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "calibrate/base/capture_set.h"
#include "calibrate/rectify/exposure_gains.h"
#include "core/report/html_page.h"

namespace raywalk::calibrate {

// "exposures differ from frame to frame; 30 of 36 frames are corrected", in one sentence.
std::string exposure_summary(const ExposureResult& exposure);

// {"summary", "links", "patches", "scene_parts", "loops", "loop_error", "significance", "kinds":
// [{"kind", "model", "spread", "t_limit", "t_limit_single", "tests": [...], "halves": [...]}]};
// natural logarithms of light.
nlohmann::ordered_json exposure_json(const CaptureSet& set, const ExposureResult& exposure);

// {"brightness": {"measured", "fitted", "error", "corrected"}, "red", "blue"} of a frame, natural
// logarithms of light.
nlohmann::ordered_json frame_exposure_json(const ExposureResult& exposure, int frame);

void add_exposure(const CaptureSet& set, const ExposureResult& exposure, HtmlPage* page);

}  // namespace raywalk::calibrate
