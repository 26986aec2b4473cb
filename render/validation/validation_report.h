// A validation as a page to look at: pictures of views beside their truth (Fig. 12 of the paper),
// gain over the distance from the line (Fig. 13), connection errors (Table 2), and every number.
#pragma once

#include <string>

#include "render/validation/validate.h"

namespace raywalk::render {

// One self-contained HTML page. `validation` has at least one view and one mode.
std::string validation_report(const Validation& validation);

}  // namespace raywalk::render
