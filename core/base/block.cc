#include "core/base/block.h"

#include <fmt/format.h>

namespace raywalk {

IndexRange Block::share_of(std::size_t items) const {
  // Unsigned 64-bit products do not overflow: items times at most kMostBlocks.
  const auto start_of = [&](int block) {
    return items * static_cast<std::size_t>(block) / static_cast<std::size_t>(count);
  };
  return {start_of(index - 1), start_of(index)};
}

std::string Block::text() const { return fmt::format("{}/{}", index, count); }

std::string listed(const std::vector<int>& numbers) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    if (last < i + 2) last = i;  // two neighbours are listed, not made a range
    parts.push_back(last == i ? std::to_string(numbers[i])
                              : fmt::format("{} to {}", numbers[i], numbers[last]));
    i = last + 1;
  }
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) text += i + 1 == parts.size() ? " and " : ", ";
    text += parts[i];
  }
  return text;
}

}  // namespace raywalk
