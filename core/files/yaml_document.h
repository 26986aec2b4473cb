// One YAML document from text, with errors of one line.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <string_view>

namespace raywalk {

// The only document of the text; a null node where there is none. Throws UsageError naming `source`
// and the line: not YAML, or something follows the first document.
YAML::Node load_yaml_document(std::string_view yaml, const std::string& source);

// "view.yaml:3: ", the start of a message about that place; without a line where there is none.
std::string yaml_place(const std::string& source, const YAML::Mark& mark);

// The same for the value of a dotted key as SettingsSchema names it ("blend.overlap_deg",
// "validation[2].axis"); without a line where the document does not hold it.
std::string yaml_place_of_key(const YAML::Node& document, const std::string& source,
                              std::string_view key);

}  // namespace raywalk
