// A share of long work: block i of n. Blocks can be done in any order and on any machines that see
// the files; what they leave is merged afterwards (core/files/block_results.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace raywalk {

// Indices [begin, end).
struct IndexRange {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t size() const { return end - begin; }
  friend bool operator==(const IndexRange&, const IndexRange&) = default;
};

// Block `index` of `count`, counted from 1; the default is all of the work.
struct Block {
  int index = 1;
  int count = 1;

  // Its share of `items` pieces of work: neighbours, in order, and as many in each block as in any
  // other or one more. Empty where there are fewer pieces than blocks.
  IndexRange share_of(std::size_t items) const;
  // Its share of pieces of different sizes, increasing indices: from the largest on, each piece
  // goes to the block with the least so far. The blocks then differ by at most the largest piece,
  // and in practice by far less.
  std::vector<std::size_t> share_of(std::span<const std::uint64_t> sizes) const;
  std::string text() const;  // "3/16"
  friend bool operator==(const Block&, const Block&) = default;
};

// Which part of a long step to do; by default all of it.
struct BlockArguments {
  std::optional<Block> block{};  // only this one; its result is kept to be merged
  bool merge = false;            // only merge what blocks left
};

// The most blocks that work can be divided into.
inline constexpr int kMostBlocks = 100'000;

// Numbers as people list them: "3, 5 to 7 and 9". `numbers` must increase.
std::string listed(const std::vector<int>& numbers);

}  // namespace raywalk
