// The HTML report of a validation: pictures of views beside their truth (Fig. 12 of the paper),
// gain over the distance from the line (Fig. 13), connection errors (Table 2), and all scores.
#pragma once

#include <string>

#include "core/judge/validation/validate.h"

namespace raywalk {

// One self-contained HTML page. `validation` has at least one view and one mode.
std::string validation_report(const Validation& validation);

}  // namespace raywalk
