// Rank correlation of two series of measurements.
#pragma once

#include <span>
#include <vector>

namespace raywalk {

// Rank of each value, 1 for the smallest; equal values share the mean of their ranks.
std::vector<double> ranks_of(std::span<const double> values);

// Spearman's rank correlation, in [-1, 1]: Pearson's correlation of the ranks, which is right for
// ties too. NaN with fewer than two pairs, or where all values of one side are equal. Both spans
// have the same length; values are finite.
double rank_correlation(std::span<const double> a, std::span<const double> b);

}  // namespace raywalk
