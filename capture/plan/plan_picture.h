// The picture of the plan that `raywalk-capture plan` draws.
#pragma once

#include <string>

#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

// An SVG file of the plan from above: cells, lines with their stations and overhang, validation
// lines dashed. A bar marks the start of each line's rail, an arrow its direction, with the line's
// id.
std::string plan_picture_svg(const CapturePlan& plan);

}  // namespace raywalk::capture
