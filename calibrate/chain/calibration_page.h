// The summary of a calibration as a page.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace raywalk::calibrate {

// A complete HTML page. `document`: of calibration.json; pictures are read from OUT.
std::string calibration_page(const nlohmann::ordered_json& document,
                             const std::filesystem::path& out);

}  // namespace raywalk::calibrate
