// From light to 8-bit sRGB and back.
#pragma once

#include <cstdint>

namespace raywalk::capture {

// The 8-bit level, not yet rounded, of linear light relative to white: highlights above 0.8 bend
// smoothly towards 1, which they never reach, and the result is encoded by the sRGB transfer curve
// (IEC 61966-2-1). Light below 0 counts as 0.
float level_from_light(float light);

}  // namespace raywalk::capture
