#include "core/evaluate/trade/dial_json.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace raywalk {
namespace {

using nlohmann::ordered_json;

// A word for 0 that is no number.
bool has_word(const Dial& dial) { return dial.zero != nullptr && std::string(dial.zero) != "0"; }

double choice_from(const Dial& dial, const CheckedJson& json) {
  const std::string name = json.text();
  for (std::size_t i = 0; i < dial.names.size(); ++i) {
    if (name == dial.names[i]) return static_cast<double>(i);
  }
  json.fail(fmt::format("is none of {}", values_text(dial)));
}

}  // namespace

ordered_json json_of(const Dial& dial, const ViewOptions& options) {
  const double value = dial.value.get(options);
  if (dial.value.kind == DialKind::kChoice || (has_word(dial) && value == 0.0)) {
    return text_of(dial, value);
  }
  if (dial.value.kind == DialKind::kInteger) return static_cast<int>(value);
  return value;
}

double value_from(const Dial& dial, const CheckedJson& json) {
  if (dial.value.kind == DialKind::kChoice) return choice_from(dial, json);
  if (has_word(dial) && json.is_text()) {
    if (json.text() != dial.zero) json.fail(fmt::format("is neither {} nor a number", dial.zero));
    return 0.0;
  }
  if (dial.value.kind == DialKind::kNumber) return json.number(dial.least, dial.most);
  const int value = json.integer(static_cast<int>(dial.least), static_cast<int>(dial.most));
  if (value % dial.multiple_of != 0) {
    json.fail(fmt::format("{} is not a multiple of {}", value, dial.multiple_of));
  }
  return value;
}

ordered_json swept_dials_json(const ViewOptions& options) {
  ordered_json json;
  for (const Dial& dial : kDials) {
    if (dial.sweep) json[dial.key] = json_of(dial, options);
  }
  return json;
}

ViewOptions options_from(const CheckedJson& json) {
  ViewOptions options;
  for (const Dial& dial : kDials) {
    if (dial.sweep) dial.value.set(&options, value_from(dial, json.at(dial.key)));
  }
  return options;
}

}  // namespace raywalk
