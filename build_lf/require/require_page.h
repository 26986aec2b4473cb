// The HTML report of `raywalk-build-lf require`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "build_lf/require/requirement_plots.h"

namespace raywalk::build_lf {

// A self-contained HTML page. `document`: of require.json.
std::string require_page(const nlohmann::ordered_json& document, const RequirementFigures& figures);

}  // namespace raywalk::build_lf
