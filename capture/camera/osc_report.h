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
// members are left out.
CameraReport osc_report(const nlohmann::json& info, const nlohmann::json& state,
                        const nlohmann::json& options);

// Whether the camera reports no room for another picture.
bool reports_full_card(const nlohmann::json& state, const nlohmann::json& options);

}  // namespace raywalk::capture
