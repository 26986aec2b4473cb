// Which stations are developed, and from which photographs.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/grid.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The stations of a room that are developed. 0: those with a distance map, which depth chooses by
// the size of the cells; of a line with less than two, those that views connect at
// (needed_stations). Else at most `stations` of them, evenly spread, but at least those that views
// connect at. Throws UsageError for a number below 0 or above that of the room's stations.
KeptStations stations_to_develop(const Room& room, int stations);

// The width of developed pictures: `asked`, or, for 0, twice the captured one up to kUsualWidth.
// Throws UsageError unless it is a multiple of 4 from the captured width to twice that.
inline constexpr int kUsualWidth = 8192;
int developed_width(PanoramaSize captured, int asked);

// The stations whose photographs a station is developed from: half of kMostSources the nearest, the
// rest spread over all that are nearer than what it sees is, on average: from there detail is
// coarser. Without itself.
inline constexpr int kMostSources = 40;
std::vector<StationIndex> sources_of(const Grid& grid, StationIndex station, double surfaces_m);

// The median distance, metres, of what is seen from `inverse` distances, 1/m; negative: unknown.
// Infinite if most is infinitely far, or nothing is known.
double median_distance_m(std::span<const float> inverse);

}  // namespace raywalk::build_lf
