#include "core/files/settings.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/words.h"
#include "core/files/yaml_document.h"

namespace raywalk {
namespace {

constexpr std::size_t kMaxSettingsBytes = std::size_t{1} << 20;

// yaml-cpp marks a plain scalar with the tag "?" and one in quotes with "!".
bool is_in_quotes(const YAML::Node& node) { return node.Tag() == "!"; }

template <typename Number>
void require_range(Number value, Number min, Number max) {
  if (!(value >= min && value <= max)) {
    throw std::invalid_argument(fmt::format("must lie between {} and {}", min, max));
  }
}

double number_from(const std::string& scalar, double min, double max) {
  const auto parsed = parse_finite_number(scalar);
  if (!parsed) throw std::invalid_argument("must be a finite number");
  require_range(*parsed, min, max);
  return *parsed;
}

template <typename Value>
std::string sequence_text(const std::vector<Value>& values) {
  return fmt::format("[{}]", fmt::join(values, ", "));
}

}  // namespace

// Applies one mapping of a document to the variables of a schema.
class SettingsReader {
 public:
  // `place` prefixes every key in messages: "" or, within items, "validation[2].".
  SettingsReader(const SettingsSchema& schema, const std::string& source, std::string place)
      : settings_(schema.settings_), source_(source), place_(std::move(place)) {}

  // Reads the mapping whose keys start with `group` ("" or "blend."). Recurses only where the
  // schema does, so that deep nesting or aliases in a hostile file cannot make it run long.
  void read_mapping(const YAML::Node& mapping, const std::string& group) {
    for (const auto& entry : mapping) {
      if (!entry.first.IsScalar()) fail(entry.first, "a key must be a single word");
      const std::string key = group + entry.first.Scalar();
      if (is_group(key)) {
        read_group(entry.second, key);
        continue;
      }
      const auto setting = settings_.find(key);
      if (setting == settings_.end()) {
        fail(entry.first,
             "unknown key " + excerpt(place_ + key) + suggestion(place_ + key, keys()));
      }
      if (!seen_.insert(key).second) {
        fail(entry.first, "key '" + place_ + key + "' appears twice");
      }
      apply(setting->second, entry.second, place_ + key);
    }
  }

 private:
  void read_group(const YAML::Node& node, const std::string& key) {
    if (!node.IsMap()) {
      fail(node,
           "'" + place_ + key + "' is a group of keys; indent them under it as 'key: value' lines");
    }
    read_mapping(node, key + ".");
  }

  // From here on `key` is the full name used in messages.
  void apply(const SettingsSchema::Setting& setting, const YAML::Node& node,
             const std::string& key) const {
    if (setting.max_count) {
      read_sequence(setting, node, key);
    } else {
      read_scalar(setting, node, key);
    }
  }

  void read_sequence(const SettingsSchema::Setting& setting, const YAML::Node& node,
                     const std::string& key) const {
    if (!node.IsSequence()) {
      fail(node, "'" + key +
                     (setting.next_item ? "' must be a list; start every item under it with '- '"
                                        : "' must be a list; write it as [first, second]"));
    }
    if (node.size() > *setting.max_count) {
      fail(node, fmt::format("'{}' has {} items; it may have {} at most", key, node.size(),
                             *setting.max_count));
    }
    if (setting.clear) setting.clear();
    for (std::size_t i = 0; i < node.size(); ++i) {
      const std::string item_key = fmt::format("{}[{}]", key, i);
      if (setting.next_item) {
        read_item(setting, node[i], item_key);
      } else {
        read_scalar(setting, node[i], item_key);
      }
    }
  }

  void read_item(const SettingsSchema::Setting& setting, const YAML::Node& node,
                 const std::string& key) const {
    if (!node.IsMap()) fail(node, "'" + key + "' must be lines of 'key: value' after '- '");
    const SettingsSchema schema = setting.next_item();
    SettingsReader(schema, source_, key + ".").read_mapping(node, "");
  }

  void read_scalar(const SettingsSchema::Setting& setting, const YAML::Node& node,
                   const std::string& key) const {
    if (!node.IsScalar()) {
      fail(node, "'" + key + (node.IsNull() ? "' has no value" : "' must be a single value"));
    }
    const std::string& scalar = node.Scalar();
    if (is_in_quotes(node) && !setting.takes_quoted) {
      fail(node, "'" + key + "' is " + excerpt(scalar) + " in quotes; write it without them");
    }
    try {
      setting.set(scalar);
    } catch (const std::invalid_argument& e) {
      fail(node, "'" + key + "' is " + excerpt(scalar) + "; it " + e.what());
    }
  }

  // Whether some key of the schema continues `key` with a dot.
  bool is_group(const std::string& key) const {
    const auto next = settings_.lower_bound(key + ".");
    return next != settings_.end() && next->first.starts_with(key + ".");
  }

  std::vector<std::string> keys() const {
    std::vector<std::string> keys;
    for (const auto& setting : settings_) keys.push_back(place_ + setting.first);
    return keys;
  }

  [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const {
    throw UsageError(yaml_place(source_, node.Mark()) + what);
  }

  const std::map<std::string, SettingsSchema::Setting>& settings_;
  const std::string& source_;
  std::string place_;
  std::set<std::string> seen_;
};

SettingsSchema& SettingsSchema::bind(std::string key, Setting setting) {
  settings_[std::move(key)] = std::move(setting);
  return *this;
}

SettingsSchema& SettingsSchema::number(std::string key, double* value, double min, double max) {
  return bind(std::move(key),
              {.set = [=](const std::string& scalar) { *value = number_from(scalar, min, max); },
               .value = [=] { return fmt::format("{}", *value); }});
}

SettingsSchema& SettingsSchema::integer(std::string key, int* value, int min, int max) {
  const auto set = [=](const std::string& scalar) {
    const auto parsed = parse_whole_or_hexadecimal_number(scalar);
    if (!parsed) throw std::invalid_argument("must be a whole number");
    require_range(*parsed, min, max);
    *value = *parsed;
  };
  return bind(std::move(key), {.set = set, .value = [=] { return fmt::format("{}", *value); }});
}

SettingsSchema& SettingsSchema::boolean(std::string key, bool* value) {
  const auto set = [=](const std::string& scalar) {
    if (scalar != "true" && scalar != "false") {
      throw std::invalid_argument("must be true or false");
    }
    *value = scalar == "true";
  };
  return bind(std::move(key), {.set = set, .value = [=] { return fmt::format("{}", *value); }});
}

SettingsSchema& SettingsSchema::text(std::string key, std::string* value) {
  return bind(std::move(key), {.set = [=](const std::string& scalar) { *value = scalar; },
                               .takes_quoted = true,
                               .value = [=] { return *value; }});
}

SettingsSchema& SettingsSchema::path(std::string key, std::filesystem::path* value) {
  return bind(std::move(key), {.set = [=](const std::string& scalar) { *value = scalar; },
                               .takes_quoted = true,
                               .value = [=] { return value->string(); }});
}

SettingsSchema& SettingsSchema::scalar(std::string key, std::function<void(const std::string&)> set,
                                       std::function<std::string()> value, bool takes_quoted) {
  return bind(std::move(key),
              {.set = std::move(set), .takes_quoted = takes_quoted, .value = std::move(value)});
}

SettingsSchema& SettingsSchema::choice(const std::string& key, std::string* value,
                                       const std::vector<std::string>& choices) {
  return bind_choice(
      key, choices, [value, choices](std::size_t i) { *value = choices[i]; },
      [value] { return *value; });
}

SettingsSchema& SettingsSchema::bind_choice(std::string key, std::vector<std::string> choices,
                                            std::function<void(std::size_t)> set,
                                            std::function<std::string()> value) {
  const auto set_named = [choices = std::move(choices),
                          set = std::move(set)](const std::string& scalar) {
    const auto choice = std::find(choices.begin(), choices.end(), scalar);
    if (choice == choices.end()) {
      throw std::invalid_argument("is not a valid choice" + suggestion(scalar, choices));
    }
    set(static_cast<std::size_t>(choice - choices.begin()));
  };
  return bind(std::move(key), {.set = set_named, .takes_quoted = true, .value = std::move(value)});
}

SettingsSchema& SettingsSchema::numbers(std::string key, std::vector<double>* values, double min,
                                        double max, std::size_t max_count) {
  return bind(
      std::move(key),
      {.set = [=](const std::string& scalar) { values->push_back(number_from(scalar, min, max)); },
       .value = [=] { return sequence_text(*values); },
       .max_count = max_count,
       .clear = [=] { values->clear(); }});
}

SettingsSchema& SettingsSchema::words(std::string key, std::vector<std::string>* values,
                                      std::size_t max_count) {
  return bind(std::move(key), {.set = [=](const std::string& scalar) { values->push_back(scalar); },
                               .takes_quoted = true,
                               .value = [=] { return sequence_text(*values); },
                               .max_count = max_count,
                               .clear = [=] { values->clear(); }});
}

SettingsSchema& SettingsSchema::items(std::string key, std::function<SettingsSchema()> next_item,
                                      std::size_t max_count) {
  return bind(std::move(key), {.max_count = max_count, .next_item = std::move(next_item)});
}

std::map<std::string, std::string> SettingsSchema::values() const {
  std::map<std::string, std::string> values;
  for (const auto& [key, setting] : settings_) {
    if (!setting.next_item) {
      values[key] = setting.value();
      continue;
    }
    for (const auto& [item_key, value] : setting.next_item().values()) {
      values[fmt::format("{}[].{}", key, item_key)] = value;
    }
  }
  return values;
}

void SettingsSchema::load(const std::filesystem::path& file) const {
  std::string yaml;
  try {
    yaml = read_file(file, kMaxSettingsBytes);
  } catch (const Error& e) {
    throw UsageError(e.what());
  }
  parse(yaml, file.string());
}

void SettingsSchema::parse(std::string_view yaml, const std::string& source) const {
  const YAML::Node document = load_yaml_document(yaml, source);
  if (document.IsNull()) return;
  if (!document.IsMap()) {
    throw UsageError(yaml_place(source, document.Mark()) +
                     "settings must be lines of 'key: value'");
  }
  SettingsReader(*this, source, "").read_mapping(document, "");
}

}  // namespace raywalk
