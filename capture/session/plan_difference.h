// The difference between a session's plan and the plan of the run that resumes it.
#pragma once

#include <string>

#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

// The first difference as text, "line x0 has 41 stations there, 61 here"; empty if there is none.
// "There" is the session. Positions are equal within a micrometre.
std::string plan_difference(const CapturePlan& there, const CapturePlan& here);

}  // namespace raywalk::capture
