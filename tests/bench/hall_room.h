// Halls of many cells, to measure what grows with the size of a room.
#pragma once

#include <filesystem>
#include <vector>

#include "core/geometry/grid.h"

namespace raywalk::bench {

// A grid of square cells of 1 m; lines share the stations where they cross.
struct Hall {
  int columns = 1;   // cells along x
  int rows = 1;      // and along z
  int steps = 50;    // between two crossings
  int overhang = 0;  // steps of every line beyond the outermost crossings
};

// A square hall with about so many stations, 2 cm apart.
Hall hall_of(int stations);

std::vector<StationPose> stations_of(const Hall& hall);

// The hall's room, with one and the same picture of `width` x width/2 pixels at every station and a
// distance map at every second one; packed on the first call and kept in the build tree.
std::filesystem::path hall_room(const Hall& hall, int width);

}  // namespace raywalk::bench
