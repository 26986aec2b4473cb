// Which stations of a room to use, where not all are.
#pragma once

#include <vector>

#include "core/room/room.h"

namespace raywalk {

// One of every `stride` (at least 1) neighbouring stations of each line: the first that has a
// distance map, else the first; and the line's own first and last one.
KeptStations every_nth_station(const Room& room, int stride);

// One of every `every` (at least 2) neighbouring stations of each line, from the middle of the
// first such group on, but never the line's first or last: those to leave out and to render again.
std::vector<std::vector<int>> held_out_stations(const Grid& grid, int every);

// All stations but `left_out` (of each line, increasing).
KeptStations all_but(const Grid& grid, const std::vector<std::vector<int>>& left_out);

// Where `raywalk-build-lf depth --hold-out` keeps distances estimated without some stations; their
// files are those of a room of the other stations alone.
std::filesystem::path held_out_directory(const std::filesystem::path& room);

}  // namespace raywalk
