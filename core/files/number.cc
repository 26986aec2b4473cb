#include "core/files/number.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

namespace raywalk {
namespace {

// std::from_chars is exact and ignores the locale, but does not accept a leading '+'.
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

std::optional<int> parse_whole_or_hexadecimal_number(std::string_view text) {
  if (!text.starts_with("0x") && !text.starts_with("0X")) return parse_whole_number(text);
  text.remove_prefix(2);
  unsigned value = 0;  // std::from_chars reads no sign into an unsigned number
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  const bool fits = error == std::errc() && end == text.data() + text.size() &&
                    value <= static_cast<unsigned>(std::numeric_limits<int>::max());
  return fits ? std::optional(static_cast<int>(value)) : std::nullopt;
}

}  // namespace raywalk
