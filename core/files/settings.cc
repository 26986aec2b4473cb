#include "core/files/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

constexpr std::size_t kMaxSettingsBytes = std::size_t{1} << 20;

int line_of(const YAML::Mark& mark) { return mark.line + 1; }  // yaml-cpp counts lines from 0

[[noreturn]] void fail_at(const std::string& source, const YAML::Mark& mark,
                          const std::string& what) {
  const std::string line = mark.is_null() ? "" : fmt::format(":{}", line_of(mark));
  throw UsageError(fmt::format("{}{}: {}", source, line, what));
}

// Records the start of the last document and ignores its content.
class DocumentStart : public YAML::EventHandler {
 public:
  YAML::Mark mark{};

  void OnDocumentStart(const YAML::Mark& start) override { mark = start; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

// The only document of the text; a null node if it is empty. YAML::Load drops whatever follows the
// first document, and YAML::LoadAll of yaml-cpp 0.7 never returns from some malformed texts
// ("{a: 1}, d}": it finds one more empty document again and again), so the parser reads two at
// most.
YAML::Node load_document(const std::string& yaml, const std::string& source) {
  try {
    std::istringstream stream(yaml);
    YAML::Parser parser(stream);
    DocumentStart start;
    if (parser.HandleNextDocument(start) && parser.HandleNextDocument(start)) {
      fail_at(source, start.mark, "text after the settings, which must be a single YAML document");
    }
    return YAML::Load(yaml);
  } catch (const YAML::Exception& e) {
    fail_at(source, e.mark, "not valid YAML (" + one_line(e.msg) + ")");
  }
}

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
  using Setting = SettingsSchema::Setting;

  // `place` prefixes every key in messages: "" or, within items, "validation[2].".
  SettingsReader(const SettingsSchema& schema, const std::string& source, std::string place,
                 SettingsLines* lines)
      : settings_(schema.settings_), source_(source), place_(std::move(place)), lines_(lines) {}

  // Reads the mapping whose keys start with `group` ("" or "blend."). Recurses only where the
  // schema does, so that deep nesting or aliases in a hostile file cannot make it run long.
  void read_mapping(const YAML::Node& mapping, const std::string& group) {
    for (const auto& entry : mapping) {
      if (!entry.first.IsScalar()) fail(entry.first, "a key must be a single word");
      const std::string key = group + entry.first.Scalar();
      const std::string full_key = place_ + key;
      if (is_group(key)) {
        if (!entry.second.IsMap()) {
          fail(entry.second, "'" + full_key + "' is a group of keys; indent them under it as " +
                                 "'key: value' lines");
        }
        read_mapping(entry.second, key + ".");
        continue;
      }
      const auto setting = settings_.find(key);
      if (setting == settings_.end()) {
        fail(entry.first, "unknown key " + excerpt(full_key) + suggestion(full_key, keys()));
      }
      const int line = line_of(entry.second.Mark());
      if (!lines_->emplace(full_key, line).second) {
        fail(entry.first, "key '" + full_key + "' appears twice");
      }
      read_value(setting->second, entry.second, full_key);
    }
  }

 private:
  // From here on `key` is the full name used in messages.
  void read_value(const Setting& setting, const YAML::Node& node, const std::string& key) const {
    if (!setting.max_count) return read_scalar(setting, node, key);
    if (!node.IsSequence()) {
      fail(node, fmt::format("'{}' must be a list; {}", key,
                             setting.next_item ? "start every item under it with '- '"
                                               : "write it as [first, second]"));
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

  void read_item(const Setting& setting, const YAML::Node& node, const std::string& key) const {
    if (!node.IsMap()) fail(node, "'" + key + "' must be lines of 'key: value' after '- '");
    const SettingsSchema schema = setting.next_item();
    SettingsReader(schema, source_, key + ".", lines_).read_mapping(node, "");
  }

  void read_scalar(const Setting& setting, const YAML::Node& node, const std::string& key) const {
    if (!node.IsScalar()) {
      fail(node, "'" + key + (node.IsNull() ? "' has no value" : "' must be a single value"));
    }
    const std::string& scalar = node.Scalar();
    // yaml-cpp marks a plain scalar with the tag "?" and one in quotes with "!".
    if (node.Tag() == "!" && !setting.takes_quoted) {
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
    fail_at(source_, node.Mark(), what);
  }

  const std::map<std::string, Setting>& settings_;
  const std::string& source_;
  std::string place_;
  SettingsLines* lines_;
};

SettingsSchema& SettingsSchema::bind(std::string key, Setting setting) {
  settings_[std::move(key)] = std::move(setting);
  return *this;
}

SettingsSchema& SettingsSchema::scalar(std::string key, std::function<void(const std::string&)> set,
                                       std::function<std::string()> value, bool takes_quoted) {
  return bind(std::move(key),
              {.set = std::move(set), .value = std::move(value), .takes_quoted = takes_quoted});
}

SettingsSchema& SettingsSchema::number(std::string key, double* value, double min, double max,
                                       double unit) {
  const auto set = [=](const std::string& scalar) {
    *value = number_from(scalar, min, max) * unit;
  };
  return scalar(
      std::move(key), set, [=] { return fmt::format("{}", *value / unit); }, false);
}

SettingsSchema& SettingsSchema::integer(std::string key, int* value, int min, int max) {
  const auto set = [=](const std::string& scalar) {
    const auto parsed = parse_whole_or_hexadecimal_number(scalar);
    if (!parsed) throw std::invalid_argument("must be a whole number");
    require_range(*parsed, min, max);
    *value = *parsed;
  };
  return scalar(
      std::move(key), set, [=] { return fmt::format("{}", *value); }, false);
}

SettingsSchema& SettingsSchema::boolean(std::string key, bool* value) {
  const auto set = [=](const std::string& scalar) {
    if (scalar != "true" && scalar != "false") {
      throw std::invalid_argument("must be true or false");
    }
    *value = scalar == "true";
  };
  return scalar(
      std::move(key), set, [=] { return fmt::format("{}", *value); }, false);
}

SettingsSchema& SettingsSchema::text(std::string key, std::string* value) {
  const auto set = [=](const std::string& scalar) { *value = scalar; };
  return scalar(
      std::move(key), set, [=] { return *value; }, true);
}

SettingsSchema& SettingsSchema::path(std::string key, std::filesystem::path* value) {
  const auto set = [=](const std::string& scalar) { *value = scalar; };
  return scalar(
      std::move(key), set, [=] { return value->string(); }, true);
}

SettingsSchema& SettingsSchema::choice(std::string key, std::string* value,
                                       std::vector<std::string> choices) {
  const auto set = [value, choices](std::size_t i) { *value = choices[i]; };
  return bind_choice(std::move(key), std::move(choices), set, [=] { return *value; });
}

SettingsSchema& SettingsSchema::bind_choice(std::string key, std::vector<std::string> choices,
                                            std::function<void(std::size_t)> set,
                                            std::function<std::string()> value) {
  const auto set_named = [choices = std::move(choices),
                          set = std::move(set)](const std::string& scalar) {
    const auto choice = std::ranges::find(choices, scalar);
    if (choice == choices.end()) {
      throw std::invalid_argument("is not a valid choice" + suggestion(scalar, choices));
    }
    set(static_cast<std::size_t>(choice - choices.begin()));
  };
  return scalar(std::move(key), set_named, std::move(value), true);
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
                               .value = [=] { return sequence_text(*values); },
                               .takes_quoted = true,
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

SettingsLines SettingsSchema::load(const std::filesystem::path& file) const {
  std::string yaml;
  try {
    yaml = read_file(file, kMaxSettingsBytes);
  } catch (const Error& e) {
    throw UsageError(e.what());
  }
  return parse(yaml, file.string());
}

SettingsLines SettingsSchema::parse(std::string_view yaml, const std::string& source) const {
  const YAML::Node document = load_document(std::string(yaml), source);
  SettingsLines lines;
  if (document.IsNull()) return lines;
  if (!document.IsMap()) {
    fail_at(source, document.Mark(), "settings must be lines of 'key: value'");
  }
  SettingsReader(*this, source, "", &lines).read_mapping(document, "");
  return lines;
}

}  // namespace raywalk
