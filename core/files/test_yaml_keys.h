// For tests: the keys of a settings file, to compare shipped files with their schema.
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <set>
#include <string>

namespace raywalk {

inline void add_yaml_keys(const YAML::Node& node, const std::string& key,
                          std::set<std::string>* keys) {
  const bool holds_items = node.IsSequence() && node.size() > 0 && node[0].IsMap();
  if (node.IsMap()) {
    for (const auto& entry : node) {
      add_yaml_keys(entry.second, (key.empty() ? "" : key + ".") + entry.first.Scalar(), keys);
    }
  } else if (holds_items) {
    for (const auto& item : node) add_yaml_keys(item, key + "[]", keys);
  } else {
    keys->insert(key);
  }
}

// Keys in the form of SettingsSchema::values(): "blend.overlap_deg", "validation[].axis".
inline std::set<std::string> keys_of_yaml(const std::filesystem::path& file) {
  std::set<std::string> keys;
  add_yaml_keys(YAML::LoadFile(file.string()), "", &keys);
  return keys;
}

}  // namespace raywalk
