// The standard deviation of normal errors, told such that outliers do not move it.
#pragma once

#include <utility>
#include <vector>

#include "core/base/median.h"

namespace raywalk {

// 1 / 0.6745: the median of the absolute value of a normal variable of mean 0 is 0.6745 standard
// deviations (Rousseeuw and Croux, Alternatives to the Median Absolute Deviation, JASA 88, 1993).
inline constexpr double kSigmaPerMad = 1.4826;

// kSigmaPerMad times the median of absolute deviations: from 0 for residuals, from the median of
// the values otherwise. In the unit of the deviations; half of them may be outliers. At least one
// value, none of them NaN.
inline double robust_sigma(std::vector<double> absolute_deviations) {
  return kSigmaPerMad * median(std::move(absolute_deviations));
}

}  // namespace raywalk
