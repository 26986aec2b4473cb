// Light and reflectance in linear RGB.
#pragma once

#include <Eigen/Core>

namespace raywalk::capture {

using Color = Eigen::Vector3f;

// Linear interpolation: `a` at share 0, `b` at share 1.
inline Color mix(const Color& a, const Color& b, float share) { return a + share * (b - a); }

// Relative luminance of linear sRGB primaries (ITU-R BT.709).
inline float luminance(const Color& color) { return color.dot(Color(0.2126F, 0.7152F, 0.0722F)); }

}  // namespace raywalk::capture
