#include "core/view/view_parameter.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/files/words.h"
#include "core/view/view_options.h"

namespace raywalk {
namespace {

std::optional<double> parsed(const ViewParameter& parameter, const std::string& text) {
  if (parameter.value.kind == ParameterKind::kNumber) return parse_finite_number(text);
  return parse_whole_or_hexadecimal_number(text);
}

}  // namespace

double default_of(const ViewParameter& parameter) {
  return parameter.zero != nullptr ? 0.0 : parameter.value.get(ViewOptions());
}

std::string values_text(const ViewParameter& parameter) {
  if (parameter.value.kind == ParameterKind::kChoice)
    return fmt::format("{}", fmt::join(parameter.names, ", "));
  std::string text = parameter.zero != nullptr ? fmt::format("{} or ", parameter.zero) : "";
  if (parameter.multiple_of > 1) {
    text += fmt::format("a multiple of {} ", parameter.multiple_of);
  } else if (parameter.value.kind == ParameterKind::kInteger) {
    text += "a whole number ";
  }
  text += fmt::format("in {:g}..{}", parameter.least, parameter.most);
  return *parameter.unit == '\0' ? text : text + " " + parameter.unit;
}

std::optional<std::string> fault_of(const ViewParameter& parameter, double value) {
  if (parameter.value.kind == ParameterKind::kChoice || (parameter.zero != nullptr && value == 0.0))
    return {};
  const bool in_range = value >= parameter.least && value <= parameter.most;  // NaN is not
  const bool steps = parameter.value.kind == ParameterKind::kNumber ||
                     std::fmod(value, parameter.multiple_of) == 0.0;
  if (in_range && steps) return {};
  return "must be " + values_text(parameter);
}

std::string text_of(const ViewParameter& parameter, double value) {
  if (parameter.value.kind == ParameterKind::kChoice)
    return parameter.names[static_cast<std::size_t>(value)];
  return parameter.zero != nullptr && value == 0.0 ? parameter.zero : fmt::format("{}", value);
}

double value_of(const ViewParameter& parameter, const std::string& text) {
  if (parameter.value.kind == ParameterKind::kChoice) {
    for (std::size_t i = 0; i < parameter.names.size(); ++i) {
      if (text == parameter.names[i]) return static_cast<double>(i);
    }
    throw std::invalid_argument("is not a valid choice" +
                                suggestion(text, {parameter.names.begin(), parameter.names.end()}));
  }
  if (parameter.zero != nullptr && text == parameter.zero) return 0.0;
  const std::optional<double> value = parsed(parameter, text);
  // The number 0 is no other name of a word such as auto.
  const bool is_word = value == 0.0 && parameter.least > 0.0;
  if (!value || is_word || fault_of(parameter, *value)) {
    throw std::invalid_argument("must be " + values_text(parameter));
  }
  return *value;
}

}  // namespace raywalk
