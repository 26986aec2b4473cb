// The width of Cauchy's loss, which bounds the pull of outliers.
#pragma once

namespace raywalk::calibrate {

// In standard deviations of the errors: Cauchy's estimate then has 95 % of the efficiency of least
// squares under normal errors (Holland and Welsch 1977).
inline constexpr double kCauchySigmas = 2.385;

}  // namespace raywalk::calibrate
