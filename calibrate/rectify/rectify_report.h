// rectify.json and rectify.html.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "calibrate/rectify/rectify_set.h"

namespace raywalk::calibrate {

// Writes both into OUT. `grid` may be null. Throws Error if a file cannot be written.
void write_rectify_report(const CaptureSet& set, const FramePoses& poses, const GridResult* grid,
                          const RectifyResult& result, const std::filesystem::path& out);

// The document of rectify.json.
nlohmann::ordered_json rectify_document(const CaptureSet& set, const FramePoses& poses,
                                        const GridResult* grid, const RectifyResult& result,
                                        const std::filesystem::path& out);

// "raywalk-build-lf pack --frames OUT/poses.csv ...", the next step.
std::string pack_command(const RectifyResult& result, const std::filesystem::path& out);

}  // namespace raywalk::calibrate
