// Strict settings from YAML: every key has a type and a range; anything else is an error that names
// file, line, key and the nearest valid key. An empty file sets nothing.
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

#include "core/files/words.h"  // IWYU pragma: export

namespace raywalk {

// The lines of a file on which its keys have their values, counted from 1: "blend.overlap_deg",
// "validation[2].axis".
using SettingsLines = std::map<std::string, int>;

// The keys a YAML mapping may hold and the variables they set. Keys carry their unit as a suffix
// (`settle_ms`). Nested mappings are written as dotted keys ("blend.overlap_deg"). The variables
// must outlive the schema.
class SettingsSchema {
 public:
  // Each binds a key to a variable, which keeps its value if the file does not set the key. Bounds
  // are inclusive; NaN and infinity are always rejected. Integers may be hexadecimal (0x6200).
  // `unit` is that of the file in the variable's: 0.001 for a key `x_mm` and a variable in metres.
  SettingsSchema& number(std::string key, double* value, double min, double max, double unit = 1.0);
  SettingsSchema& integer(std::string key, int* value, int min, int max);
  SettingsSchema& boolean(std::string key, bool* value);
  SettingsSchema& text(std::string key, std::string* value);
  // As written; the caller resolves a relative path against the file's directory.
  SettingsSchema& path(std::string key, std::filesystem::path* value);
  SettingsSchema& choice(std::string key, std::string* value, std::vector<std::string> choices);
  // One of the enumerators `choices`, which a file names as name_of(Enum) does.
  template <typename Enum>
  requires std::is_enum_v<Enum> SettingsSchema& choice(
      const std::string& key, Enum* value, std::span<const std::type_identity_t<Enum>> choices);
  // A scalar that `set` reads; it throws std::invalid_argument with the reason that it is not valid
  // ("must be ..."). `value` is the current one. Only text and choices may stand in quotes.
  SettingsSchema& scalar(std::string key, std::function<void(const std::string&)> set,
                         std::function<std::string()> value, bool takes_quoted);

  // Sequences of up to `max_count` values ("[0, -2, 2]"). A sequence in the file, even an empty
  // one, replaces the whole of `values`. Messages name an element "bracket_ev[1]", counted from 0.
  SettingsSchema& numbers(std::string key, std::vector<double>* values, double min, double max,
                          std::size_t max_count);
  SettingsSchema& words(std::string key, std::vector<std::string>* values, std::size_t max_count);
  // A sequence of up to `max_count` mappings. `next_item` is called before each is read and returns
  // the schema of that item, bound to variables that must live until the next call. Messages name a
  // key of an item "validation[2].axis".
  SettingsSchema& items(std::string key, std::function<SettingsSchema()> next_item,
                        std::size_t max_count);

  // Every key with the current value of its variable, in YAML syntax ("[0, -2]" for a sequence);
  // keys of items as "validation[].axis" with the default values of an item (calls `next_item`
  // once).
  std::map<std::string, std::string> values() const;

  // Throws UsageError: not YAML, not a mapping, unknown or duplicate key, wrong type, out of range.
  // Form: "view.yaml:3: unknown key 'overlap_dge'; did you mean 'overlap_deg'?"
  SettingsLines load(const std::filesystem::path& file) const;
  SettingsLines parse(std::string_view yaml, const std::string& source) const;

 private:
  friend class SettingsReader;  // keeps yaml-cpp out of this header

  struct Setting {
    // Sets the scalar, or appends to the sequence; throws std::invalid_argument with the reason
    // that it does not fit.
    std::function<void(const std::string& scalar)> set{};
    std::function<std::string()> value{};
    bool takes_quoted = false;               // text may be quoted, numbers and booleans may not
    std::optional<std::size_t> max_count{};  // of a sequence; none: a scalar
    std::function<void()> clear{};           // empties a sequence of scalars
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
    const std::string& key, Enum* value, std::span<const std::type_identity_t<Enum>> choices) {
  std::vector<std::string> names;
  for (const Enum choice : choices) names.emplace_back(name_of(choice));
  const std::vector<Enum> values(choices.begin(), choices.end());
  return bind_choice(
      key, std::move(names), [value, values](std::size_t i) { *value = values[i]; },
      [value] { return std::string(name_of(*value)); });
}

}  // namespace raywalk
