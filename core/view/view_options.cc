#include "core/view/view_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <stdexcept>

#include "core/base/error.h"

namespace raywalk {
namespace {

void require_in_range(const Dial& dial, const ViewOptions& options) {
  const double value = dial.value.get(options);
  const bool unresolved = dial.zero != nullptr && value == 0.0;
  const std::optional<std::string> fault =
      unresolved ? "must be chosen before a view is rendered" : fault_of(dial, value);
  if (fault) throw UsageError(fmt::format("{} is {}; it {}", dial.key, value, *fault));
}

}  // namespace

const Dial& dial_of(std::string_view key) {
  for (const Dial& dial : kDials) {
    if (key == dial.key) return dial;
  }
  throw std::out_of_range(fmt::format("no dial {}", key));
}

ViewOptions default_options() {
  ViewOptions options;
  for (const Dial& dial : kDials) dial.value.set(&options, default_of(dial));
  return options;
}

std::string text_of(const ViewOptions& options) {
  std::string text;
  const auto add = [&](const Dial& dial) {
    text += fmt::format("{}={} ", dial.key, text_of(dial, dial.value.get(options)));
  };
  for (const Dial& dial : kDials) add(dial);
  return text;
}

std::string generation_name(Generation generation) {
  return kGenerationNames[static_cast<std::size_t>(generation)];
}

Generation generation_from_name(const std::string& name) {
  for (std::size_t i = 0; i < kGenerationNames.size(); ++i) {
    if (name == kGenerationNames[i]) return static_cast<Generation>(i);
  }
  throw UsageError(
      fmt::format("unknown generation '{}'; use {}", name, fmt::join(kGenerationNames, ", ")));
}

void require_view_options(const ViewOptions& options) {
  for (const Dial& dial : kDials) require_in_range(dial, options);
}

}  // namespace raywalk
