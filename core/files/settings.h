// Strict settings from YAML: every key is documented, typed and ranged; anything else is an error
// that names file, line, key and the nearest valid key. An empty file sets nothing.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/files/nearest_word.h"  // IWYU pragma: export

namespace raywalk {

// The keys a YAML mapping may hold and the variables they set. Keys carry their unit as a suffix
// (`settle_ms`). Nested mappings are written as dotted keys ("blend.overlap_deg").
class SettingsSchema {
 public:
  // Each binds a key to a variable, which keeps its value where the file does not set it. Bounds
  // are inclusive; NaN and infinity are always refused.
  SettingsSchema& number(std::string key, double* value, double min, double max);
  SettingsSchema& integer(std::string key, int* value, int min, int max);
  SettingsSchema& boolean(std::string key, bool* value);
  SettingsSchema& text(std::string key, std::string* value);
  SettingsSchema& choice(std::string key, std::string* value, std::vector<std::string> choices);

  // Throws UsageError: not YAML, not a mapping, unknown or duplicate key, wrong type, out of range.
  // Form: "view.yaml:3: unknown key 'overlap_dge'; did you mean 'overlap_deg'?"
  void load(const std::filesystem::path& file) const;
  void parse(std::string_view yaml, const std::string& source) const;

 private:
  friend class SettingsReader;  // walks the YAML tree, which this header keeps to itself

  // Throws std::invalid_argument with the reason a scalar does not fit.
  using Setter = std::function<void(const std::string& scalar)>;
  struct Setting {
    Setter set;
    bool takes_quoted;  // text may be written in quotes, a number or a boolean may not
  };
  SettingsSchema& bind(std::string key, bool takes_quoted, Setter set);

  std::map<std::string, Setting> settings_;
};

}  // namespace raywalk
