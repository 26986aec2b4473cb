// Some lines of a plan, for a session of their own: captured on another day or by another rig, and
// merged with the rest later (capture/session/merge_sessions.h).
#pragma once

#include <string>
#include <vector>

#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

// The plan of the lines named, in the order of `plan`. A word is the id of a line, "x3", or a range
// of the plan's order, "x3-x6". No words: the plan itself, as where they name all lines. Throws
// UsageError naming the word that is neither.
CapturePlan select_lines(const CapturePlan& plan, const CameraConfig& camera,
                         const std::vector<std::string>& words);

// The plan that it is a part of, or itself: its lines, and the SHA-256 over its plan_json without
// positions on the rail: what lines, stations and pictures it has, whatever rail they are captured
// with. Sessions with equal ones belong together.
WholePlan whole_plan_of(const CapturePlan& plan, const CameraConfig& camera);

}  // namespace raywalk::capture
