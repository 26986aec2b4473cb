// Runs of a column's rows that are read in the same way.
#pragma once

#include <cstdint>

#include "core/room/line_volume.h"

namespace raywalk {

enum class Reading : std::uint8_t {
  kNothing,
  kStored,  // rows of the plain cut, uncorrected
  kFirst,   // samples of the station before the acquisition point, or of the one after it
  kSecond,
  kBoth
};

// Whether the station before (0) or after (1) the acquisition point is sampled.
inline bool reads(Reading reading, int next) {
  return reading == Reading::kBoth || reading == (next == 0 ? Reading::kFirst : Reading::kSecond);
}

struct RowPiece {
  RowRun rows;  // of the output
  Reading reading = Reading::kBoth;
};

}  // namespace raywalk
