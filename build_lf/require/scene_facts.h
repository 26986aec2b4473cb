// Facts about a room's scene, from its distances.
#pragma once

#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Side of the fields of directions, ordered from the nadir up and from -180 degrees on; fields
// without a known distance are omitted.
inline constexpr double kFieldDeg = 15.0;

// Distance ranges over all directions and per field, and their reliability. Throws Error if the
// room has no known distance.
DistanceFacts distance_facts(const Room& room);

// The typical d_p, metres, for which layers and storage are computed: half the shorter side of the
// smallest cell; without cells, half the side of the cell that the longest line could close.
double typical_reach_m(const Grid& grid);

// The layers needed for `tolerance_rad` at d_p from a tenth of `reach_m` up to the diagonal of a
// cell.
LayerFacts layer_facts(const DistanceFacts& distance, double reach_m, double tolerance_rad);

}  // namespace raywalk::build_lf
