// Parses a single YAML document, with one-line errors.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <string_view>

namespace raywalk {

// The document in the text; a null node if it is empty. Throws UsageError naming `source` and the
// line: not YAML, or more than one document.
YAML::Node load_yaml_document(std::string_view yaml, const std::string& source);

// "view.yaml:3: ", the prefix of an error message; without line number if `mark` has none.
std::string yaml_place(const std::string& source, const YAML::Mark& mark);

// The same for the value of a dotted key of SettingsSchema ("blend.overlap_deg",
// "validation[2].axis"); without line number if the document does not hold it.
std::string yaml_place_of_key(const YAML::Node& document, const std::string& source,
                              std::string_view key);

}  // namespace raywalk
