// Subsets of a room's stations.
#pragma once

#include <span>
#include <vector>

#include "core/room/room.h"

namespace raywalk {

// The stations to hold out and re-render: of every `every` (at least 2) consecutive stations of
// each line the middle one, never the line's first or last.
std::vector<std::vector<int>> held_out_stations(const Grid& grid, int every);

// All stations except `left_out` ([line], increasing indices).
KeptStations stations_except(const Grid& grid, const std::vector<std::vector<int>>& left_out);

// Increasing indices of stations of `line` with no gap wider than `spacing_m`, except where the
// captured gap is wider. The first, the last and the station nearest to each intersection with
// another line are always kept, because the views of a cell connect there. In between, selection is
// greedy: the next station is the farthest one within `spacing_m`, if possible one of `preferred`
// (increasing; stations with a distance map). An infinite spacing keeps only the fixed stations.
std::vector<int> needed_stations(const Grid& grid, int line, double spacing_m,
                                 std::span<const int> preferred);

enum class Preferred { kAny, kWithDistances };

// The same of all lines of a room; kWithDistances prefers the stations with a distance map.
KeptStations needed_stations(const Room& room, double spacing_m,
                             Preferred preferred = Preferred::kAny);

// Where `raywalk-build-lf depth --hold-out` stores distances estimated without the held-out
// stations. Station indices in its files are those of the room without them.
std::filesystem::path held_out_directory(const std::filesystem::path& room);

}  // namespace raywalk
