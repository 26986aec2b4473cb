// What a camera of the Open Spherical Camera API says of itself.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/camera/camera.h"

namespace raywalk::capture {

// The options that osc_report reads.
const std::vector<std::string>& report_option_names();

// From the answers to /osc/info and /osc/state and the options, each an object; what is missing or
// makes no sense is left out. The options were told at `told_at` of this machine's clock.
// `header_offset_s` is the camera's clock minus this machine's by the Date header; it counts where
// the camera has no dateTimeZone.
CameraReport osc_report(const nlohmann::json& info, const nlohmann::json& state,
                        const nlohmann::json& options, WallTime told_at,
                        std::optional<double> header_offset_s);

// Whether there is no room for another picture.
bool tells_full_card(const nlohmann::json& state, const nlohmann::json& options);

}  // namespace raywalk::capture
