// A share of long work: several machines that see the same files do the parts in any order, and a
// run without parts does what is missing and finishes.
#pragma once

#include <cstddef>

namespace raywalk::build_lf {

// Indices [begin, end).
struct IndexRange {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t size() const { return end - begin; }
};

// The most parts that work can be divided into.
inline constexpr int kMostParts = 100'000;

// WorkPart `index` of `count`, counted from 1; the default is all of the work.
struct WorkPart {
  int index = 1;
  int count = 1;

  // Its share of `items` pieces of work: neighbours, as many as in any other part or one more.
  // Empty where there are fewer pieces than parts.
  IndexRange share_of(std::size_t items) const {
    const auto start_of = [&](int part) {  // no overflow: at most kMostParts times the items
      return items * static_cast<std::size_t>(part) / static_cast<std::size_t>(count);
    };
    return {start_of(index - 1), start_of(index)};
  }
};

}  // namespace raywalk::build_lf
