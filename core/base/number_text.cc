#include "core/base/number_text.h"

#include <array>
#include <charconv>
#include <cmath>

namespace raywalk {

std::string fixed_number(double value, int decimals) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value < 0.0 ? "-inf" : "inf";
  // The largest double has 309 digits before the point.
  std::array<char, 400> buffer;
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                          std::chars_format::fixed, decimals);
  const std::string_view text(buffer.data(), static_cast<std::size_t>(end - buffer.data()));
  const bool is_zero = text.find_first_of("123456789") == std::string_view::npos;
  return std::string(is_zero && text.starts_with('-') ? text.substr(1) : text);
}

std::string number_or_dash(double value, int decimals) {
  return std::isfinite(value) ? fixed_number(value, decimals) : "–";
}

std::string plain_number(double value, int decimals) {
  std::string text = fixed_number(value, decimals);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string counted(std::size_t count, std::string_view noun) {
  return std::to_string(count) + " " + std::string(noun) + (count == 1 ? "" : "s");
}

}  // namespace raywalk
