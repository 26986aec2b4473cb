// Distances from dense optical flow along the line, the paper's method (V-F-2); a baseline for the
// plane sweep.
#pragma once

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/station_picture.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Triangulates every pixel from the optical flow to the two stations of its line closest to a
// quarter of `reach_m` away, one on either side (at the ends of the line one side only). `gains` is
// [line][station].
//
// Confidence grows with parallax and with forward-backward consistency of the flow. It is 0 along
// the rail, where a line has no parallax, and where both sides fail the consistency check. Such
// pixels take the farther of the nearest valid surfaces in their row.
InverseDistanceMap flow_map(const Room& room, StationIndex station, double reach_m,
                            PanoramaSize map_size, const GainFields& gains);

}  // namespace raywalk::build_lf
