#include "core/files/number.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace raywalk {
namespace {

// std::from_chars is exact and ignores the locale, but knows no leading '+'.
template <typename Number>
std::optional<Number> parse_all(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Number value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> parse_finite_number(std::string_view text) {
  const auto value = parse_all<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<int> parse_whole_number(std::string_view text) { return parse_all<int>(text); }

}  // namespace raywalk
