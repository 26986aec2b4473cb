// The report of raywalk-calibrate grid.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace raywalk::calibrate {

// A complete HTML page: lines, candidate models, crossings before and after, the plan with
// exaggerated corrections, and the stations' deviations along each line. `document`: of grid.json;
// `drawing`: by grid_drawing.
std::string grid_page(const nlohmann::ordered_json& document, const std::string& drawing);

}  // namespace raywalk::calibrate
