// What the distances of a room say of its scene.
#pragma once

#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Fields of 15 x 15 degrees, from the nadir up and from -180 degrees on; those without a known
// distance are left out.
inline constexpr double kFieldDeg = 15.0;

// Ranges over all directions and per field, and how trustworthy they are. Throws Error where the
// room knows no distance.
DistanceFacts distance_facts(const Room& room);

// d_p at which a room's layers are counted and its storage is chosen: half the smallest cell's
// shorter side; without cells, half of what the longest line could close.
double typical_reach_m(const Grid& grid);

// The layers for `tolerance_rad` from a tenth of the typical reach up to the farthest point of a
// cell, its diagonal.
LayerFacts layer_facts(const DistanceFacts& distance, double reach_m, double tolerance_rad);

}  // namespace raywalk::build_lf
