// The state of a camera with the Open Spherical Camera API.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "capture/camera/camera.h"

namespace raywalk::capture {

// The options that osc_report reads.
const std::vector<std::string>& report_option_names();

// From the replies to /osc/info and /osc/state and the options, each an object; missing or invalid
// members are left out. `options_at` is the time of the options by this machine's clock.
CameraReport osc_report(const nlohmann::json& info, const nlohmann::json& state,
                        const nlohmann::json& options, WallTime options_at);

// Whether the camera reports no room for another picture.
bool reports_full_card(const nlohmann::json& state, const nlohmann::json& options);

}  // namespace raywalk::capture
