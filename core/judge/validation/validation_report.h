// The HTML report of a validation: pictures of views beside their truth (Fig. 12 of the paper),
// gain over the distance from the line (Fig. 13), connection errors (Table 2), and all scores.
#pragma once

#include <optional>
#include <string>

#include "core/judge/validation/before_after.h"
#include "core/judge/validation/validate.h"

namespace raywalk {

// One self-contained HTML page. `validation` has at least one mode, and at least one view unless
// two rooms are compared.
std::string validation_report(const Validation& validation,
                              const std::optional<BeforeAfter>& compared = std::nullopt);

}  // namespace raywalk
