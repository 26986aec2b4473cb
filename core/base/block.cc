#include "core/base/block.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

namespace raywalk {

IndexRange Block::share_of(std::size_t items) const {
  // Unsigned 64-bit products do not overflow: items times at most kMostBlocks.
  const auto start_of = [&](int block) {
    return items * static_cast<std::size_t>(block) / static_cast<std::size_t>(count);
  };
  return {start_of(index - 1), start_of(index)};
}

std::vector<std::size_t> Block::share_of(std::span<const std::uint64_t> sizes) const {
  std::vector<std::size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sizes[a] > sizes[b]; });
  // Load and index of every block, the least loaded first.
  using Load = std::pair<std::uint64_t, int>;
  std::priority_queue<Load, std::vector<Load>, std::greater<>> loads;
  for (int block = 1; block <= count; ++block) loads.emplace(0, block);
  std::vector<std::size_t> share;
  for (const std::size_t piece : order) {
    const auto [load, block] = loads.top();
    loads.pop();
    // Pieces of no size are work too.
    loads.emplace(load + std::max<std::uint64_t>(sizes[piece], 1), block);
    if (block == index) share.push_back(piece);
  }
  std::sort(share.begin(), share.end());
  return share;
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
