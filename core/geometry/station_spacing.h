// How far apart the stations of a capture are. Internal to find_grid (grid.h).
#pragma once

#include <span>

#include "core/geometry/grid.h"

namespace raywalk {

// How far apart stations typically are, metres: the median distance to the second nearest station
// at another position, as the nearest may belong to another pass of the same line; to the nearest
// where the second is in the same direction, as at the end of a line. 0 if all stations are at one
// position.
double typical_spacing(std::span<const StationPose> stations);

// The same to the nearest station.
double median_nearest_distance(std::span<const StationPose> stations);

}  // namespace raywalk
