// Branch-free single-precision arc tangent for inner loops, which compilers can vectorise.
//
// The project's geometry is in double (core/geometry); these loops only turn directions into pixel
// positions, where 6e-7 rad is a thousandth of a pixel at W = 8192.
#pragma once

#include <cmath>

namespace raywalk {
namespace {  // internal linkage: each file is compiled for its own instruction set

// atan(x) for x in [0, 1], absolute error below 3.5e-7: odd polynomial of degree 13, minimax on
// [0, 1] by iteratively reweighted least squares (coefficients of x, x^3, ... x^13).
[[maybe_unused]] inline float fast_atan_unit(float x) {
  // Estrin's scheme: fewer operations wait for each other than in Horner's.
  const float x2 = x * x, x4 = x2 * x2;
  const float low = (0.999996112f - 0.333173681f * x2) + (0.198078155f - 0.132333417f * x2) * x4;
  const float high = (0.0796236641f - 0.0336042128f * x2) + 0.0068117906f * x4;
  return (low + high * (x4 * x4)) * x;
}

// atan2(y, x) for arguments that are 0 or normal numbers, absolute error below 5.5e-7 rad; 0 for
// (0, 0).
[[maybe_unused]] inline float fast_atan2(float y, float x) {
  const float ax = std::fabs(x);
  const float ay = std::fabs(y);
  const float larger = ax > ay ? ax : ay;
  const float smaller = ax > ay ? ay : ax;
  // The smallest normal number keeps 0 / 0 at 0.
  const float ratio = smaller / (larger > 1.17549435e-38f ? larger : 1.17549435e-38f);
  float angle = fast_atan_unit(ratio);
  angle = ay > ax ? 1.57079633f - angle : angle;
  angle = x < 0.0f ? 3.14159265f - angle : angle;
  return y < 0.0f ? -angle : angle;
}

}  // namespace
}  // namespace raywalk
