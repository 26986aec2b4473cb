#include "core/view/dial.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/files/words.h"
#include "core/view/view_options.h"

namespace raywalk {
namespace {

std::optional<double> parsed(const Dial& dial, const std::string& text) {
  if (dial.value.kind == DialKind::kNumber) return parse_finite_number(text);
  return parse_whole_or_hexadecimal_number(text);
}

}  // namespace

double default_of(const Dial& dial) {
  return dial.zero != nullptr ? 0.0 : dial.value.get(ViewOptions());
}

std::string values_text(const Dial& dial) {
  if (dial.value.kind == DialKind::kChoice) return fmt::format("{}", fmt::join(dial.names, ", "));
  std::string text = dial.zero != nullptr ? fmt::format("{} or ", dial.zero) : "";
  if (dial.multiple_of > 1) {
    text += fmt::format("a multiple of {} ", dial.multiple_of);
  } else if (dial.value.kind == DialKind::kInteger) {
    text += "a whole number ";
  }
  text += fmt::format("in {:g}..{}", dial.least, dial.most);
  return *dial.unit == '\0' ? text : text + " " + dial.unit;
}

std::optional<std::string> fault_of(const Dial& dial, double value) {
  if (dial.value.kind == DialKind::kChoice || (dial.zero != nullptr && value == 0.0)) return {};
  const bool in_range = value >= dial.least && value <= dial.most;  // NaN is not
  const bool steps =
      dial.value.kind == DialKind::kNumber || std::fmod(value, dial.multiple_of) == 0.0;
  if (in_range && steps) return {};
  return "must be " + values_text(dial);
}

std::string text_of(const Dial& dial, double value) {
  if (dial.value.kind == DialKind::kChoice) return dial.names[static_cast<std::size_t>(value)];
  return dial.zero != nullptr && value == 0.0 ? dial.zero : fmt::format("{}", value);
}

double value_of(const Dial& dial, const std::string& text) {
  if (dial.value.kind == DialKind::kChoice) {
    for (std::size_t i = 0; i < dial.names.size(); ++i) {
      if (text == dial.names[i]) return static_cast<double>(i);
    }
    throw std::invalid_argument("is not a valid choice" +
                                suggestion(text, {dial.names.begin(), dial.names.end()}));
  }
  if (dial.zero != nullptr && text == dial.zero) return 0.0;
  const std::optional<double> value = parsed(dial, text);
  // The number 0 is no other name of a word such as auto.
  const bool is_word = value == 0.0 && dial.least > 0.0;
  if (!value || is_word || fault_of(dial, *value)) {
    throw std::invalid_argument("must be " + values_text(dial));
  }
  return *value;
}

}  // namespace raywalk
