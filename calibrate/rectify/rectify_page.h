// The report of raywalk-calibrate rectify.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "core/report/json_page.h"

namespace raywalk::calibrate {

// A complete HTML page. `document`: of rectify.json; pictures are read from OUT.
std::string rectify_page(const nlohmann::ordered_json& document, const std::filesystem::path& out);

// A part shared with other pages: the overlays of a list with the keys of rectify.json's crossings;
// nothing if it is empty.
void add_overlays(std::string_view list, const std::filesystem::path& out, const JsonPage& page);

}  // namespace raywalk::calibrate
