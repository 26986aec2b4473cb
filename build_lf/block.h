// A share of long work: several machines that see the same files do the blocks in any order, and a
// run without blocks does what is missing and finishes.
#pragma once

#include <cstddef>

namespace raywalk::build_lf {

// Indices [begin, end).
struct IndexRange {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t size() const { return end - begin; }
};

// The most blocks that work can be divided into.
inline constexpr int kMostBlocks = 100'000;

// Block `index` of `count`, counted from 1; the default is all of the work.
struct Block {
  int index = 1;
  int count = 1;

  // Its share of `items` pieces of work: neighbours, as many as in any other block or one more.
  // Empty where there are fewer pieces than blocks.
  IndexRange share_of(std::size_t items) const {
    const auto start_of = [&](int block) {  // no overflow: at most kMostBlocks times the items
      return items * static_cast<std::size_t>(block) / static_cast<std::size_t>(count);
    };
    return {start_of(index - 1), start_of(index)};
  }
};

}  // namespace raywalk::build_lf
