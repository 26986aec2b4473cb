// Student's t distribution.
#pragma once

namespace raywalk::calibrate {

// The probability that |t| exceeds `size` (at least 0) with `freedom` degrees of freedom, 1 to
// 1000.
double two_sided_probability(double size, int freedom);

// The |t| that is exceeded with `probability`, in (0, 1).
double two_sided_quantile(double probability, int freedom);

}  // namespace raywalk::calibrate
