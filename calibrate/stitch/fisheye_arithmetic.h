// Constants shared by the kernels. No functions, as every kernel file is compiled for another
// instruction set.
#pragma once

#include "core/panorama/srgb.h"

namespace raywalk::calibrate {

inline constexpr float kShift = static_cast<float>(kSrgbShift_levels);
inline constexpr float kToe = static_cast<float>(kSrgbToe_levels);

// Catmull-Rom weights of the samples at -1, 0, 1, 2 for a position t in [0, 1) are the polynomials
//   ((kCubic[3] t + kCubic[2]) t + kCubic[1]) t + kCubic[0].
alignas(16) inline constexpr float kCubic[4][4] = {{0.0F, 1.0F, 0.0F, 0.0F},
                                                   {-0.5F, 0.0F, 0.5F, 0.0F},
                                                   {1.0F, -2.5F, 2.0F, -0.5F},
                                                   {-0.5F, 1.5F, -1.5F, 0.5F}};

}  // namespace raywalk::calibrate
