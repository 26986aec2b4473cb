// The plan as a picture: what `raywalk-capture plan` draws for the operator.
#pragma once

#include <string>

#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

// An <svg> file: cells, lines with their stations seen from above, the stretches beyond the outer
// corners, validation lines dashed; a bar where the rail of each line begins, an arrow where it
// leads, and the line's id.
std::string plan_picture_svg(const CapturePlan& plan);

}  // namespace raywalk::capture
