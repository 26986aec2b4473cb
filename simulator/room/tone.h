// Conversion of linear light to 8-bit sRGB.
#pragma once

#include <cstdint>

namespace raywalk::capture {

enum class Highlights {
  kSoft,    // light above 0.8 is compressed smoothly towards white
  kClipped  // light above white is white
};

// The 8-bit level, not rounded, of linear light relative to white, encoded with the sRGB transfer
// function (IEC 61966-2-1). Light below 0 counts as 0.
float level_from_light(float light, Highlights highlights = Highlights::kSoft);

}  // namespace raywalk::capture
