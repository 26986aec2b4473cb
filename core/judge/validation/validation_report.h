// The HTML report of a validation: pictures of views beside their truth (Fig. 12 of the paper),
// gain over the distance from the line (Fig. 13), connection errors (Table 2), and all scores.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/judge/validation/validate.h"

namespace raywalk {

// One self-contained HTML page. `document`: of metrics.json; `samples`: of Validation.
std::string validation_report(const nlohmann::ordered_json& document,
                              const std::vector<PictureSample>& samples);

}  // namespace raywalk
