#include "core/report/json_scope.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/report/json_format.h"

namespace raywalk {
namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void fail(std::string_view what, std::string_view where) {
  throw std::logic_error(fmt::format("report: '{}': {}", where, what));
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

std::vector<std::string_view> keys_of(std::string_view path) {
  return path == "." ? std::vector<std::string_view>{} : split(path, '.');
}

const Json& member(const Json& value, std::string_view key, std::string_view path) {
  if (value.is_array()) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
    if (error != std::errc() || end != key.data() + key.size() || index >= value.size()) {
      fail("no such entry", path);
    }
    return value[index];
  }
  const auto found = value.is_object() ? value.find(std::string(key)) : value.end();
  if (found == value.end()) fail("no such key", path);
  return *found;
}

// "LEFT OPERATOR RIGHT", or LEFT alone.
struct Expression {
  explicit Expression(std::string_view text) {
    const std::vector<std::string_view> words = split(text, ' ');
    if (words.size() != 1 && words.size() != 3) fail("is no expression", text);
    left = words.front();
    if (words.size() == 1) return;
    operation = words[1];
    right = words[2];
  }

  std::string_view left, operation, right;
};

bool is_comparison(std::string_view operation) {
  return operation == "<" || operation == ">" || operation == "<=" || operation == ">=";
}

bool compare(double a, std::string_view operation, double b) {
  if (operation == "<") return a < b;
  if (operation == ">") return a > b;
  return operation == "<=" ? a <= b : a >= b;
}

double number_of(const Json& value, std::string_view path) {
  if (is_nothing(value)) return std::numeric_limits<double>::quiet_NaN();
  if (!value.is_number()) fail("no number", path);
  return value.get<double>();
}

bool is_true(const Json& value) {
  if (is_nothing(value)) return false;
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number()) return value.get<double>() != 0.0;
  return value.is_string() ? !value.get_ref<const std::string&>().empty() : !value.empty();
}

}  // namespace

JsonScope::JsonScope(const Json& document) : levels_{&document} {}

JsonScope JsonScope::at(std::string_view path) const {
  std::string_view rest = path;
  JsonScope scope = start_of(&rest);
  for (const std::string_view key : keys_of(rest)) scope.enter(key, path);
  return scope;
}

const Json& JsonScope::value(std::string_view path) const { return *at(path).levels_.back(); }

std::vector<JsonScope> JsonScope::entries(std::string_view path) const {
  std::string_view rest = path;
  std::vector<JsonScope> found{start_of(&rest)};
  for (const std::string_view key : keys_of(rest)) {
    if (!found.empty() && found.front().levels_.back()->is_array()) found = entries_of(found);
    for (JsonScope& scope : found) scope.enter(key, path);
  }
  for (const JsonScope& scope : found) {
    const Json& list = *scope.levels_.back();
    if (!list.is_array() && !list.is_null()) fail("no list", path);
  }
  return entries_of(found);
}

JsonScope JsonScope::start_of(std::string_view* path) const {
  JsonScope scope = *this;
  if (path->starts_with('/')) {
    scope.levels_.resize(1);
    path->remove_prefix(1);
  }
  for (; path->starts_with('^'); path->remove_prefix(1)) {
    do {
      if (scope.levels_.size() == 1) fail("nothing is around the root", *path);
      scope.levels_.pop_back();
    } while (!scope.levels_.back()->is_object());
  }
  return scope;
}

void JsonScope::enter(std::string_view key, std::string_view path) {
  levels_.push_back(&member(*levels_.back(), key, path));
}

std::vector<JsonScope> JsonScope::entries_of(const std::vector<JsonScope>& lists) {
  std::vector<JsonScope> entries;
  for (const JsonScope& list : lists) {
    for (const Json& entry : *list.levels_.back()) {
      entries.push_back(list);
      entries.back().levels_.push_back(&entry);
    }
  }
  return entries;
}

double JsonScope::number(std::string_view expression) const {
  const Expression parts(expression);
  const double left = number_of(value(parts.left), parts.left);
  if (parts.operation.empty()) return left;
  if (parts.operation == "/") return left / number_of(value(parts.right), parts.right);
  if (parts.operation != "as") fail("no number", expression);
  if (parts.right == "cm") return 100.0 * left;
  if (parts.right == "MB") return 1e-6 * left;
  fail("no such unit", expression);
}

bool JsonScope::holds(std::string_view expression) const {
  if (expression.starts_with('!')) return !holds(expression.substr(1));
  const Expression parts(expression);
  if (parts.operation.empty()) return is_true(value(parts.left));
  if (parts.operation == "is") return value(parts.left) == Json(std::string(parts.right));
  if (!is_comparison(parts.operation)) fail("no condition", expression);
  return compare(number(parts.left), parts.operation, number(parts.right));
}

std::string JsonScope::placeholder(std::string_view expression, std::string_view format) const {
  const std::string_view operation = Expression(expression).operation;
  if (operation == "/" || operation == "as") return formatted(number(expression), format);
  if (!operation.empty() || expression.starts_with('!')) {
    return formatted(holds(expression), format);
  }
  return formatted(value(expression), format);
}

std::string JsonScope::text(std::string_view text) const {
  std::string filled;
  while (!text.empty()) {
    const std::size_t brace = std::min(text.find_first_of("{}"), text.size());
    filled += text.substr(0, brace);
    text.remove_prefix(brace);
    if (text.starts_with("{{") || text.starts_with("}}")) {
      filled += text.front();
      text.remove_prefix(2);
    } else if (!text.empty()) {
      const std::size_t end = text.find('}');
      if (end == 0 || end == std::string_view::npos) fail("a brace alone", text);
      const std::string_view inside = text.substr(1, end - 1);
      const std::size_t colon = std::min(inside.find(':'), inside.size());
      filled +=
          placeholder(inside.substr(0, colon), inside.substr(std::min(colon + 1, inside.size())));
      text.remove_prefix(end + 1);
    }
  }
  return filled;
}

}  // namespace raywalk
