// How far apart the stations of a capture are.
#pragma once

#include <span>

#include "core/geometry/grid.h"

namespace raywalk {

// How far apart stations typically are, metres: the median distance to the second nearest station
// at another position, as the nearest may belong to another pass of the same line; to the nearest
// where the second is in the same direction, as at the end of a line. 0 if all stations are at one
// position. Of many stations a thousand are measured.
double typical_spacing(std::span<const StationPose> stations);

}  // namespace raywalk
