// Lengths in messages, in millimetres as in the options of the commands.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace raywalk {

// "4.27 mm"; from a metre on whole millimetres.
inline std::string mm_text(double metres) {
  const double mm = metres * 1e3;
  return std::abs(mm) < 1e3 ? fmt::format("{:.3g} mm", mm) : fmt::format("{:.0f} mm", mm);
}

// A length for an option --...-mm that is at least `metres` > 0: the next larger number of two
// digits.
inline std::string mm_at_least(double metres) {
  const double step = std::pow(10.0, std::floor(std::log10(metres * 1e3)) - 1.0);
  return fmt::format("{:.6g}", std::ceil(metres * 1e3 / step) * step);
}

}  // namespace raywalk
