// Conversion of linear light to 8-bit sRGB.
#pragma once

#include <cstdint>

namespace raywalk::capture {

// The 8-bit level, not rounded, of linear light relative to white. Highlights above 0.8 are
// compressed smoothly towards 1; the result is encoded with the sRGB transfer function (IEC
// 61966-2-1). Light below 0 counts as 0.
float level_from_light(float light);

}  // namespace raywalk::capture
