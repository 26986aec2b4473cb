// What E_connect (connect_error.h) is the mean of. All sums are of whole numbers, so that they are
// the same however the work is divided and in whatever order it is added up.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace raywalk {

// A whole number of up to 96 bits: rooms of many cells have sums beyond 64.
struct WideSum {
  std::uint64_t high = 0;  // counts 2^32
  std::uint64_t low = 0;   // below 2^32

  void add(std::uint64_t value);
  void add(const WideSum& other);
  double value() const;
  friend bool operator==(const WideSum&, const WideSum&) = default;
};

// Over output columns of overlaps.
struct OverlapSum {
  WideSum squared_difference{};  // of all samples of the columns, in squared 8-bit levels
  std::int64_t columns = 0;

  void add_column(std::uint64_t squared_difference_of_it);
  void add(const OverlapSum& other);
  // Over the samples; NaN where there was no column.
  double mean(int samples_per_column) const;
};

// Over pairs (viewpoint, corner).
struct ConnectErrorSums {
  struct AtK {
    OverlapSum all{};
    OverlapSum common{};     // over the pairs that are readable at every k
    std::int64_t pairs = 0;  // with a column
  };
  std::vector<AtK> at_k{};  // one for each k of the list
  std::int64_t pairs = 0;
  std::int64_t common_pairs = 0;

  explicit ConnectErrorSums(std::size_t k_count) : at_k(k_count) {}
  // The sums of one pair at each k.
  void add_pair(std::span<const OverlapSum> pair);
};

}  // namespace raywalk
