// Subsets of a room's stations.
#pragma once

#include <vector>

#include "core/room/room.h"

namespace raywalk {

// Of every `stride` (at least 1) consecutive stations of each line the first with a distance map,
// or the first if none has one; and always the line's first and last station.
KeptStations every_nth_station(const Room& room, int stride);

// The stations to hold out and re-render: of every `every` (at least 2) consecutive stations of
// each line the middle one, never the line's first or last.
std::vector<std::vector<int>> held_out_stations(const Grid& grid, int every);

// All stations except `left_out` ([line], increasing indices).
KeptStations stations_except(const Grid& grid, const std::vector<std::vector<int>>& left_out);

// Where `raywalk-build-lf depth --hold-out` stores distances estimated without the held-out
// stations. Station indices in its files are those of the room without them.
std::filesystem::path held_out_directory(const std::filesystem::path& room);

}  // namespace raywalk
