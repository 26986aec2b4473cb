// Whether two measurements put the same things in the same order.
#pragma once

#include <span>
#include <vector>

namespace raywalk::render {

// Rank of each value, 1 for the smallest; equal values share the mean of their ranks.
std::vector<double> ranks_of(std::span<const double> values);

// Spearman's rank correlation, in [-1, 1]: Pearson's correlation of the ranks, so that ties count
// as what they are. NaN with fewer than two pairs, or where one side holds one value only. Both
// spans are of one length; values are finite.
double rank_correlation(std::span<const double> a, std::span<const double> b);

}  // namespace raywalk::render
