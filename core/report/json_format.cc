#include "core/report/json_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/base/counted.h"
#include "core/report/markup.h"

namespace raywalk {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kDash = "–";

[[noreturn]] void fail_format(const Json& value, std::string_view format) {
  throw std::logic_error(
      fmt::format("report: '{}' is no format for {}", format,
                  value.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 60)));
}

// Cuts `prefix` off the front of `text`, if it is there.
bool take(std::string_view prefix, std::string_view* text) {
  if (!text->starts_with(prefix)) return false;
  text->remove_prefix(prefix.size());
  return true;
}

// A space or "°": letters would be of an unknown format.
bool is_unit_start(char c) { return c == ' ' || static_cast<unsigned char>(c) >= 0x80; }

bool is_number_type(char c) { return c == 'e' || c == 'f' || c == 'g'; }

// The part of printf's format at the front of `format`, e.g. "+.2f"; the rest is a unit.
std::string_view number_format(std::string_view format) {
  const std::size_t sign = format.starts_with('+') ? 1 : 0;
  std::size_t end = sign;
  if (format.substr(end).starts_with('.')) {
    const std::size_t digits = end + 1;
    end = std::min(format.find_first_not_of("0123456789", digits), format.size());
    if (end == digits) return {};
  }
  if (end < format.size() && is_number_type(format[end])) ++end;
  return format.substr(0, end);
}

std::string without_sign_of_zero(std::string text) {
  const std::string_view digits = std::string_view(text).substr(0, text.find('e'));
  const bool is_zero = digits.find_first_of("123456789") == std::string_view::npos;
  if (is_zero && (text.starts_with('-') || text.starts_with('+'))) text.erase(0, 1);
  return text;
}

std::string number_text(const Json& value, std::string_view format) {
  std::string_view unit = format;
  const std::string_view spec = number_format(format);
  unit.remove_prefix(spec.size());
  const bool percent = take("%", &unit);
  if (!unit.empty() && !is_unit_start(unit.front())) fail_format(value, format);
  if (spec.empty() && !percent) {
    if (!value.is_number_integer()) fail_format(value, format);
    return value.dump() + std::string(unit);
  }
  const bool has_type = !spec.empty() && is_number_type(spec.back());
  const std::string number_spec = fmt::format("{{:{}{}}}", spec, has_type ? "" : "f");
  const double number = (percent ? 100.0 : 1.0) * value.get<double>();
  return without_sign_of_zero(fmt::format(fmt::runtime(number_spec), number)) +
         (percent ? " %" : "") + std::string(unit);
}

std::string length_text(double metres) {
  return metres < 0.01 ? fixed_number(1000.0 * metres, 1) + " mm"
                       : fixed_number(100.0 * metres, 1) + " cm";
}

std::string list_text(const Json& list, std::string_view format) {
  if (format == "size") return std::to_string(list.size());
  if (take("counted ", &format)) return counted(list.size(), format);
  if (format != "joined") fail_format(list, format);
  std::string text;
  for (const Json& entry : list) text += (text.empty() ? "" : ", ") + formatted(entry, "");
  return text;
}

}  // namespace

bool is_nothing(const Json& value) {
  return value.is_null() || (value.is_number_float() && !std::isfinite(value.get<double>()));
}

std::string formatted(const Json& value, std::string_view format) {
  const std::size_t bar = format.rfind('|');
  const std::string_view main = format.substr(0, bar);
  const std::string_view otherwise =
      bar == std::string_view::npos ? std::string_view() : format.substr(bar + 1);
  if (is_nothing(value)) {
    return std::string(bar == std::string_view::npos ? kDash : otherwise);
  }
  if (value.is_boolean()) {
    if (format.empty()) return value.get<bool>() ? "yes" : "no";
    if (bar == std::string_view::npos) fail_format(value, format);
    return std::string(value.get<bool>() ? main : otherwise);
  }
  if (value.is_array()) return list_text(value, main);
  if (value.is_string() && main.empty()) return value.get<std::string>();
  if (!value.is_number()) fail_format(value, format);
  if (main == "length") return length_text(value.get<double>());
  std::string_view noun = main;
  if (value.is_number_integer() && take("counted ", &noun)) {
    return counted(value.get<std::size_t>(), noun);
  }
  return number_text(value, main);
}

}  // namespace raywalk
