#include "core/files/settings.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/number.h"
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

}  // namespace

// Applies one document to the variables of a schema.
class SettingsReader {
 public:
  SettingsReader(const SettingsSchema& schema, const std::string& source)
      : settings_(schema.settings_), source_(source) {}

  // Reads the mapping whose keys start with `group` ("" or "blend."). It goes deeper only where the
  // schema does, so that neither nesting nor aliases in a hostile file can make it run long.
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
        fail(entry.first, "unknown key " + excerpt(key) + suggestion(key, keys()));
      }
      if (!seen_.insert(key).second) fail(entry.first, "key '" + key + "' appears twice");
      apply(setting->second, entry.second, key);
    }
  }

 private:
  void read_group(const YAML::Node& node, const std::string& key) {
    if (!node.IsMap()) {
      fail(node, "'" + key + "' is a group of keys; indent them under it as 'key: value' lines");
    }
    read_mapping(node, key + ".");
  }

  void apply(const SettingsSchema::Setting& setting, const YAML::Node& node,
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
    for (const auto& setting : settings_) keys.push_back(setting.first);
    return keys;
  }

  [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const {
    throw UsageError(yaml_place(source_, node.Mark()) + what);
  }

  const std::map<std::string, SettingsSchema::Setting>& settings_;
  const std::string& source_;
  std::set<std::string> seen_;
};

SettingsSchema& SettingsSchema::bind(std::string key, bool takes_quoted, Setter set) {
  settings_[std::move(key)] = {std::move(set), takes_quoted};
  return *this;
}

SettingsSchema& SettingsSchema::number(std::string key, double* value, double min, double max) {
  return bind(std::move(key), false, [=](const std::string& scalar) {
    const auto parsed = parse_finite_number(scalar);
    if (!parsed) throw std::invalid_argument("must be a finite number");
    require_range(*parsed, min, max);
    *value = *parsed;
  });
}

SettingsSchema& SettingsSchema::integer(std::string key, int* value, int min, int max) {
  return bind(std::move(key), false, [=](const std::string& scalar) {
    const auto parsed = parse_whole_number(scalar);
    if (!parsed) throw std::invalid_argument("must be a whole number");
    require_range(*parsed, min, max);
    *value = *parsed;
  });
}

SettingsSchema& SettingsSchema::boolean(std::string key, bool* value) {
  return bind(std::move(key), false, [=](const std::string& scalar) {
    if (scalar != "true" && scalar != "false") {
      throw std::invalid_argument("must be true or false");
    }
    *value = scalar == "true";
  });
}

SettingsSchema& SettingsSchema::text(std::string key, std::string* value) {
  return bind(std::move(key), true, [=](const std::string& scalar) { *value = scalar; });
}

SettingsSchema& SettingsSchema::choice(std::string key, std::string* value,
                                       std::vector<std::string> choices) {
  return bind(std::move(key), true,
              [value, choices = std::move(choices)](const std::string& scalar) {
                if (std::find(choices.begin(), choices.end(), scalar) == choices.end()) {
                  throw std::invalid_argument("is not a choice" + suggestion(scalar, choices));
                }
                *value = scalar;
              });
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
  SettingsReader(*this, source).read_mapping(document, "");
}

}  // namespace raywalk
