// Strict settings from YAML: every key is documented, typed and ranged; anything else is an error
// that names file, line, key and the nearest valid key. An empty file sets nothing.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/files/nearest_word.h"  // IWYU pragma: export

namespace raywalk {

// The keys a YAML mapping may hold and the variables they set. Keys carry their unit as a suffix
// (`settle_ms`). Nested mappings are written as dotted keys ("blend.overlap_deg"). The variables
// have to outlive the schema's use.
class SettingsSchema {
 public:
  // Each binds a key to a variable, which keeps its value where the file does not set it. Bounds
  // are inclusive; NaN and infinity are always refused. Whole numbers may be hexadecimal (0x6200).
  SettingsSchema& number(std::string key, double* value, double min, double max);
  SettingsSchema& integer(std::string key, int* value, int min, int max);
  SettingsSchema& boolean(std::string key, bool* value);
  SettingsSchema& text(std::string key, std::string* value);
  // As written; whoever reads the file makes a relative path relative to it.
  SettingsSchema& path(std::string key, std::filesystem::path* value);
  SettingsSchema& choice(std::string key, std::string* value, std::vector<std::string> choices);
  // One of the enumerators `choices`, which a file names as name_of(Enum) does.
  template <typename Enum>
  requires std::is_enum_v<Enum> SettingsSchema& choice(
      std::string key, Enum* value, std::span<const std::type_identity_t<Enum>> choices);

  // Sequences of up to `most` values ("[0, -2, 2]"); one that is given replaces all that `values`
  // held, also where it is empty. Messages name an element "bracket_ev[1]", counted from 0.
  SettingsSchema& numbers(std::string key, std::vector<double>* values, double min, double max,
                          std::size_t most);
  SettingsSchema& words(std::string key, std::vector<std::string>* values, std::size_t most);
  // A sequence of up to `most` mappings. `next_item` is called before each is read and returns the
  // schema of that item, bound to variables that have to last until the next call. Messages name
  // a key of an item "validation[2].axis".
  SettingsSchema& items(std::string key, std::function<SettingsSchema()> next_item,
                        std::size_t most);

  // Every key with the value that its variable holds, as a file would have it ("[0, -2]" for a
  // sequence); keys of items as "validation[].axis" with the values of a new item, for which
  // `next_item` is called once.
  std::map<std::string, std::string> values() const;

  // Throws UsageError: not YAML, not a mapping, unknown or duplicate key, wrong type, out of range.
  // Form: "view.yaml:3: unknown key 'overlap_dge'; did you mean 'overlap_deg'?"
  void load(const std::filesystem::path& file) const;
  void parse(std::string_view yaml, const std::string& source) const;

 private:
  friend class SettingsReader;  // walks the YAML tree, which this header keeps to itself

  // Throws std::invalid_argument with the reason a scalar does not fit.
  using Setter = std::function<void(const std::string& scalar)>;
  struct Setting {
    Setter set{};               // of a scalar, or of the next one of a sequence
    bool takes_quoted = false;  // text may be written in quotes, a number or a boolean may not
    std::function<std::string()> value{};
    std::optional<std::size_t> most{};  // of a sequence; none: a single value
    std::function<void()> clear{};      // of a sequence of scalars
    std::function<SettingsSchema()> next_item{};
  };
  SettingsSchema& bind(std::string key, Setting setting);
  // `set` takes the index of the choice.
  SettingsSchema& bind_choice(std::string key, std::vector<std::string> choices,
                              std::function<void(std::size_t)> set,
                              std::function<std::string()> value);

  std::map<std::string, Setting> settings_;
};

template <typename Enum>
requires std::is_enum_v<Enum> SettingsSchema& SettingsSchema::choice(
    std::string key, Enum* value, std::span<const std::type_identity_t<Enum>> choices) {
  std::vector<std::string> names;
  for (const Enum choice : choices) names.emplace_back(name_of(choice));
  const std::vector<Enum> values(choices.begin(), choices.end());
  return bind_choice(
      std::move(key), std::move(names), [value, values](std::size_t i) { *value = values[i]; },
      [value] { return std::string(name_of(*value)); });
}

}  // namespace raywalk
