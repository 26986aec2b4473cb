// The file of a station's distances, stations/NAME.inverse, as the page reads it.
//
// One zlib stream (RFC 1950) of 2 * w * h bytes, w wide and h = w / 2 high: the low bytes of all
// values, then their high bytes, each [row][column] from the zenith down. A value is stored as its
// difference, modulo 65536, to the value above it, the first row's as they are. Inverse distance =
// value * step; 0 is infinitely far.
#pragma once

#include <cstddef>
#include <vector>

#include "core/room/distance_maps.h"

namespace raywalk::render {

inline constexpr int kLargestInverseValue = 65535;

// The content of the file. `step_per_m` > 0; inverse distances above 65535 steps become that.
std::vector<std::byte> encode_inverse(const InverseMap& map, double step_per_m);

}  // namespace raywalk::render
