// Solves for the gains of a room's stations, as a whole and over their spheres of directions.
//
// Automatic exposure, several lenses and passing clouds make two stations show one surface in
// different levels. Where a distance map tells which pixels of two stations show one surface, the
// ratio of their levels is measured; the gains that make all of them agree are solved for together.
#pragma once

#include <span>
#include <vector>

#include "build_lf/gains/surface_maps.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The gains of `stations` (increasing; others keep those of `initial`): `initial` times what the
// surfaces in `maps` say in addition, if that is beyond its error (gain_significance.h). `initial`
// has no local gains. Each station is compared with the nearest stations that have a map, on its
// own line and on others. The result does not depend on the number of threads. Memory grows with
// the number of stations, by at most some 1 MB each.
//
// Ratios determine gains only up to a common factor: the mean logarithm of what is added is 0 in
// every channel.
GainFields solve_room_gains(const Room& room, std::span<const StationIndex> stations,
                            const SurfaceMaps& maps, const GainFields& initial);

}  // namespace raywalk::build_lf
