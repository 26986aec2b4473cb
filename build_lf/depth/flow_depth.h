// Distances from dense optical flow along the line, the paper's way (V-F-2), to compare the plane
// sweep with.
#pragma once

#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/station_picture.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Follows every pixel from the station to the stations of its line that are about a quarter of
// `reach_m` away on either side (the nearest to that; at the ends of the line one side only) and
// triangulates. `gains` is [line][station].
//
// Confidence grows with the parallax of the direction and with how well the flow there and back
// agree; it is 0 along the rail, where a line has no parallax, and where neither side can be
// trusted. Such pixels take the farther of the nearest trusted surfaces of their row.
InverseDistanceMap flow_map(const Room& room, StationIndex station, double reach_m,
                            PanoramaSize map_size,
                            const std::vector<std::vector<ColourGain>>& gains);

}  // namespace raywalk::build_lf
