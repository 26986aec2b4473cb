#include "calibrate/rectify/student_t.h"

#include <cmath>

#include "core/geometry/sphere.h"

namespace raywalk::calibrate {
namespace {

// The integral of cos^power from `from` to pi / 2, by Simpson's rule.
double integral_of_power(double from, double power) {
  constexpr int kIntervals = 400;
  const double step = (kHalfPi - from) / kIntervals;
  double sum = 0.0;
  for (int i = 0; i <= kIntervals; ++i) {
    const double weight = i == 0 || i == kIntervals ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    sum += weight * std::pow(std::cos(std::min(from + i * step, kHalfPi)), power);
  }
  return sum * step / 3.0;
}

}  // namespace

// With t = sqrt(freedom) tan(a) the density is proportional to cos(a)^(freedom - 1).
double two_sided_probability(double size, int freedom) {
  const double from = std::atan(size / std::sqrt(static_cast<double>(freedom)));
  return integral_of_power(from, freedom - 1.0) / integral_of_power(0.0, freedom - 1.0);
}

double two_sided_quantile(double probability, int freedom) {
  constexpr int kHalvings = 60;
  double low = 0.0, high = 1.0;
  while (two_sided_probability(high, freedom) > probability) high *= 2.0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (two_sided_probability(middle, freedom) > probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace raywalk::calibrate
