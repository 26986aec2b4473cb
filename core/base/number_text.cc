#include "core/base/number_text.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>

namespace raywalk {

std::string fixed_number(double value, int decimals) {
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  const bool is_zero = text.find_first_not_of("-0.") == std::string::npos;
  return is_zero && text.starts_with('-') ? text.substr(1) : text;
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

std::string mm_text(double metres) {
  const double mm = metres * 1e3;
  return std::abs(mm) < 1e3 ? fmt::format("{:.3g} mm", mm) : fmt::format("{:.0f} mm", mm);
}

std::string mm_at_least(double metres) {
  const double step = std::pow(10.0, std::floor(std::log10(metres * 1e3)) - 1.0);
  return fmt::format("{:.6g}", std::ceil(metres * 1e3 / step) * step);
}

std::string counted(std::size_t count, std::string_view noun) {
  return std::to_string(count) + " " + std::string(noun) + (count == 1 ? "" : "s");
}

}  // namespace raywalk
