// The text of a JSON file.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace raywalk {

// Indented, with a line break at its end. Numbers that are not finite are null; bytes that are not
// UTF-8, e.g. in the name of a file, are replaced.
std::string json_text(const nlohmann::ordered_json& document);

}  // namespace raywalk
