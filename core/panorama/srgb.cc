#include "core/panorama/srgb.h"

#include <cmath>

namespace raywalk {

double srgb_level_from_linear(double linear) {
  const double encoded =
      linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / kSrgbExponent) - 0.055;
  return 255.0 * encoded;
}

double linear_from_srgb_level(double level) {
  if (level <= kSrgbToe_levels) return level / 255.0 / 12.92;
  return std::pow((level + kSrgbShift_levels) / (255.0 + kSrgbShift_levels), kSrgbExponent);
}

}  // namespace raywalk
