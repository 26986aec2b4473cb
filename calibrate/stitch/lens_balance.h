// The difference in brightness of a camera's two lenses, and its correction.
#pragma once

#include <array>
#include <cmath>

#include "core/panorama/srgb.h"

namespace raywalk::calibrate {

// Vignetting model: relative to its axis, a lens transmits at the angle t
//   exp(falloff_2 t^2 + falloff_4 t^4)
// of the light, the same for both lenses. The back lens transmits `back_gain` (blue, green, red)
// times as much as the front lens. The default is the identity. The polynomial is even by symmetry
// about the axis. In the exponent it never reaches 0, and the logarithms of measured ratios are
// linear in its coefficients.
struct LensBalance {
  std::array<double, 3> back_gain{1.0, 1.0, 1.0};
  double falloff_2 = 0.0;
  double falloff_4 = 0.0;

  // Share of the light on the axis that arrives at an angle, radians.
  double share_at(double angle_rad) const {
    const double square = angle_rad * angle_rad;
    return std::exp(square * (falloff_2 + square * falloff_4));
  }
};

// The factor for shifted sRGB levels (core/panorama/srgb.h) that corrects a factor of light. The
// reference is the front lens on its axis.
inline double root_of_light(double factor) { return std::pow(factor, -1.0 / kSrgbExponent); }

}  // namespace raywalk::calibrate
