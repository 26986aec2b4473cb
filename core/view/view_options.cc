#include "core/view/view_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <stdexcept>

#include "core/base/error.h"

namespace raywalk {
namespace {

void require_in_range(const ViewParameter& parameter, const ViewOptions& options) {
  const double value = parameter.value.get(options);
  const bool unresolved = parameter.zero != nullptr && value == 0.0;
  const std::optional<std::string> fault =
      unresolved ? "must be chosen before a view is rendered" : fault_of(parameter, value);
  if (fault) throw UsageError(fmt::format("{} is {}; it {}", parameter.key, value, *fault));
}

}  // namespace

const ViewParameter& parameter_of(std::string_view key) {
  for (const ViewParameter& parameter : kViewParameters) {
    if (key == parameter.key) return parameter;
  }
  throw std::out_of_range(fmt::format("no parameter {}", key));
}

ViewOptions default_options() {
  ViewOptions options;
  for (const ViewParameter& parameter : kViewParameters)
    parameter.value.set(&options, default_of(parameter));
  return options;
}

std::string text_of(const ViewOptions& options) {
  std::string text;
  const auto add = [&](const ViewParameter& parameter) {
    text += fmt::format("{}={} ", parameter.key, text_of(parameter, parameter.value.get(options)));
  };
  for (const ViewParameter& parameter : kViewParameters) add(parameter);
  return text;
}

std::string method_name(ViewMethod method) {
  return kViewMethodNames[static_cast<std::size_t>(method)];
}

ViewMethod method_from_name(const std::string& name) {
  for (std::size_t i = 0; i < kViewMethodNames.size(); ++i) {
    if (name == kViewMethodNames[i]) return static_cast<ViewMethod>(i);
  }
  throw UsageError(
      fmt::format("unknown method '{}'; use {}", name, fmt::join(kViewMethodNames, ", ")));
}

void require_view_options(const ViewOptions& options) {
  for (const ViewParameter& parameter : kViewParameters) require_in_range(parameter, options);
}

}  // namespace raywalk
