// In what a session's plan differs from the one it is asked to go on with.
#pragma once

#include <string>

#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

// The first difference in words, "line x0 has 41 stations there, 61 here"; empty where there is
// none. "There" is the session. Lines and stations count as the same within a micrometre.
std::string plan_difference(const CapturePlan& there, const CapturePlan& here);

// The same for what plan_json says besides, "frames is "panorama" there, "dual-fisheye" here".
// Throws Error where either text is no JSON.
std::string json_difference(const std::string& there, const std::string& here);

}  // namespace raywalk::capture
