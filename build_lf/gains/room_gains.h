// Solves for the gains of a room's stations, as a whole and over their spheres of directions.
//
// Automatic exposure, several lenses and passing clouds make two stations show one surface in
// different levels. Where a distance map tells which pixels of two stations show one surface, the
// ratio of their levels is measured; the gains that make all of them agree are solved for together.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "build_lf/gains/patch_ratios.h"
#include "build_lf/gains/surface_maps.h"
#include "core/base/block.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// What two stations show of the same surfaces.
struct StationRatios {
  int from = 0;  // index in the list of stations
  int to = 0;
  std::vector<PatchRatio> patches;
};

// Compares the stations `share` of the list (increasing) each with the nearest stations that have a
// map, on its own line and on others; ordered by station. The result does not depend on the number
// of threads.
std::vector<StationRatios> compare_stations(const Room& room,
                                            std::span<const StationIndex> stations,
                                            const SurfaceMaps& maps, IndexRange share);

// Ratios as bytes and back. Throws Error for other bytes.
std::string bytes_of(const std::vector<StationRatios>& ratios);
std::vector<StationRatios> ratios_of(std::string_view bytes);

// The gains of `stations` (increasing; others keep those of `initial`): `initial` times what the
// surfaces say in addition, if that is beyond its error (gain_significance.h). `ratios`: of
// compare_stations() for all stations, in order. `initial` has no local gains. The result does not
// depend on the number of threads. Memory grows with the number of stations, by at most some 1 MB
// each.
//
// Ratios determine gains only up to a common factor: the mean logarithm of what is added is 0 in
// every channel.
GainFields solve_room_gains(std::span<const StationIndex> stations,
                            std::vector<StationRatios> ratios, const GainFields& initial);

// Both in one.
GainFields solve_room_gains(const Room& room, std::span<const StationIndex> stations,
                            const SurfaceMaps& maps, const GainFields& initial);

}  // namespace raywalk::build_lf
