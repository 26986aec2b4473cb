// Solves for the gains of a room's stations, as a whole and over their spheres of directions.
//
// Automatic exposure, several lenses and passing clouds make two stations show one surface in
// different levels. Where a distance map tells which pixels of two stations show one surface, the
// ratio of their levels is measured; the gains that make all of them agree are solved for together.
#pragma once

#include "build_lf/exposure/surface_maps.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The gains of all stations: what the surfaces say, if that is beyond its error
// (gain_significance.h), after comparing them by the surfaces in `maps`. The result does not depend
// on the number of threads.
//
// Gains of whole pictures are solved for together. Those of their patches are solved for in windows
// of at most `most_at_once` stations and some around them (gain_solver.h), so that memory is
// bounded: some 0.5 MB per station of a window. What was measured is meanwhile in files without
// names in the room's directory, some 200 kB per station. Throws Error if that cannot be written;
// Interrupted.
//
// Ratios determine gains only up to a common factor: the mean logarithm is 0 in every channel.
GainFields solve_room_gains(const Room& room, const SurfaceMaps& maps, int most_at_once = 1500);

}  // namespace raywalk::build_lf
