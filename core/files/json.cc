#include "core/files/json.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {

using Json = nlohmann::ordered_json;

std::string json_text(const Json& document) {
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

struct CheckedJson::Document {
  Json root{};
  std::string advice{};
};

CheckedJson CheckedJson::parse(const std::string& text, const std::string& source,
                               const std::string& advice) {
  constexpr int kDeepest = 16;
  auto document = std::make_shared<Document>(Document{.advice = advice});
  CheckedJson root(document, &document->root, source);
  const auto limit_depth = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > kDeepest) root.fail("nested too deeply");
    return true;
  };
  try {
    document->root = Json::parse(text, limit_depth);
  } catch (const Json::exception& error) {
    root.fail(fmt::format("damaged ({})", one_line(error.what())));
  }
  return root;
}

CheckedJson CheckedJson::read(const std::filesystem::path& file, const std::string& advice) {
  return parse(read_file(file), file.string(), advice);
}

void CheckedJson::fail(const std::string& what) const {
  const std::string& advice = document_->advice;
  throw Error(fmt::format("{}: {}{}{}", place_, what, advice.empty() ? "" : "; ", advice));
}

void CheckedJson::fail_as_found(const std::string& what) const {
  constexpr std::size_t kLongest = 40;
  std::string found = value_->dump(-1, ' ', true, Json::error_handler_t::replace);
  if (found.size() > kLongest) found = found.substr(0, kLongest) + "...";
  fail(fmt::format("{} {}", found, what));
}

void CheckedJson::require(bool is_right, const char* type) const {
  if (!is_right) fail_as_found(fmt::format("is not {}", type));
}

void CheckedJson::require_version(int newest) const {
  const int version = at("format_version").integer(1);
  if (version <= newest) return;
  const std::string& advice = document_->advice;
  throw Error(
      fmt::format("{}: format version {} is newer than {}, the newest this program reads; use a "
                  "newer Raywalk{}{}",
                  place_, version, newest, advice.empty() ? "" : ", or ", advice));
}

CheckedJson CheckedJson::at(const std::string& key) const {
  require(value_->is_object(), "an object");
  const auto found = value_->find(key);
  if (found == value_->end()) fail(fmt::format("has no '{}'", key));
  return {document_, &*found, fmt::format("{}: {}", place_, key)};
}

bool CheckedJson::has(const std::string& key) const {
  return value_->is_object() && value_->contains(key);
}

bool CheckedJson::is_null() const { return value_->is_null(); }

std::vector<std::pair<std::string, CheckedJson>> CheckedJson::members() const {
  require(value_->is_object(), "an object");
  std::vector<std::pair<std::string, CheckedJson>> members;
  for (const auto& [key, value] : value_->items()) {
    members.emplace_back(key, CheckedJson(document_, &value, fmt::format("{}: {}", place_, key)));
  }
  return members;
}

std::vector<CheckedJson> CheckedJson::items() const {
  require(value_->is_array(), "a list");
  std::vector<CheckedJson> items;
  for (std::size_t i = 0; i < value_->size(); ++i) {
    items.push_back({document_, &(*value_)[i], fmt::format("{}[{}]", place_, i)});
  }
  return items;
}

std::vector<CheckedJson> CheckedJson::items(std::size_t count) const {
  std::vector<CheckedJson> items = this->items();
  if (items.size() != count) fail(fmt::format("does not have {} elements", count));
  return items;
}

std::string CheckedJson::text() const {
  require(value_->is_string(), "a string");
  return value_->get<std::string>();
}

std::vector<std::string> CheckedJson::texts() const {
  std::vector<std::string> texts;
  for (const CheckedJson& item : items()) texts.push_back(item.text());
  return texts;
}

bool CheckedJson::boolean() const {
  require(value_->is_boolean(), "a boolean");
  return value_->get<bool>();
}

int CheckedJson::integer(int min, int max) const {
  const std::string wanted = fmt::format("between {} and {}", min, max);
  if (!value_->is_number_integer()) fail_as_found("is not an integer " + wanted);
  // As a double, what int cannot hold stays large, where get<int>() would wrap it.
  const auto value = value_->get<double>();
  if (value < min || value > max) fail_as_found("is not " + wanted);
  return static_cast<int>(value);
}

double CheckedJson::number(double min, double max) const {
  require(value_->is_number(), "a number");
  const auto value = value_->get<double>();
  if (!(value >= min && value <= max)) {
    fail_as_found(fmt::format("is not between {:g} and {:g}", min, max));
  }
  return value;
}

}  // namespace raywalk
