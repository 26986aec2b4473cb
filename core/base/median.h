// The median, and a standard deviation that outliers do not move.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace raywalk {

// The median of `values`: at least one, none NaN. The upper of the two middle values if their
// number is even.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// 1 / 0.6745: the median of the absolute value of a normal variable of mean 0 is 0.6745 standard
// deviations (Rousseeuw and Croux, Alternatives to the Median Absolute Deviation, JASA 88, 1993).
inline constexpr double kSigmaPerMad = 1.4826;

// The standard deviation of normal errors: kSigmaPerMad times the median of absolute deviations,
// from 0 for residuals, from the median of the values otherwise. In the unit of the deviations;
// half of them may be outliers. At least one value, none of them NaN.
inline double robust_sigma(std::vector<double> absolute_deviations) {
  return kSigmaPerMad * median(std::move(absolute_deviations));
}

}  // namespace raywalk
