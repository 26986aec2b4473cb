// The sRGB transfer curve (IEC 61966-2-1), which encodes 8-bit pictures.
//
// Above a short linear toe the curve is a pure power of shifted levels,
//   linear = ((level / 255 + 0.055) / 1.055)^2.4,
// so that light multiplied by f becomes (level + 0.055 * 255) f^(1/2.4) - 0.055 * 255: an affine
// function of the level.
#pragma once

namespace raywalk {

inline constexpr double kSrgbExponent = 2.4;
inline constexpr double kSrgbShift_levels = 0.055 * 255.0;
// The end of the linear toe.
inline constexpr double kSrgbToe_levels = 0.04045 * 255.0;

// Conversion between linear light in [0, 1] and continuous levels in [0, 255].
double srgb_level_from_linear(double linear);
double linear_from_srgb_level(double level);

}  // namespace raywalk
