#include "core/evaluate/validation/connect_error_sums.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raywalk {
namespace {

constexpr int kLowBits = 32;
constexpr std::uint64_t kLowMask = (std::uint64_t{1} << kLowBits) - 1;

}  // namespace

void WideSum::add(std::uint64_t value) { add(WideSum{value >> kLowBits, value & kLowMask}); }

void WideSum::add(const WideSum& other) {
  low += other.low;
  high += other.high + (low >> kLowBits);
  low &= kLowMask;
}

double WideSum::value() const {
  return std::ldexp(static_cast<double>(high), kLowBits) + static_cast<double>(low);
}

void OverlapSum::add_column(std::uint64_t squared_difference_of_it) {
  squared_difference.add(squared_difference_of_it);
  ++columns;
}

void OverlapSum::add(const OverlapSum& other) {
  squared_difference.add(other.squared_difference);
  columns += other.columns;
}

double OverlapSum::mean(int samples_per_column) const {
  if (columns == 0) return std::numeric_limits<double>::quiet_NaN();
  return squared_difference.value() / (static_cast<double>(columns) * samples_per_column);
}

void ConnectErrorSums::add_pair(std::span<const OverlapSum> pair) {
  ++pairs;
  const bool common =
      std::ranges::all_of(pair, [](const OverlapSum& sum) { return sum.columns > 0; });
  if (common) ++common_pairs;
  for (std::size_t k = 0; k < pair.size(); ++k) {
    at_k[k].all.add(pair[k]);
    if (common) at_k[k].common.add(pair[k]);
    if (pair[k].columns > 0) ++at_k[k].pairs;
  }
}

}  // namespace raywalk
