// Which distance maps of a room a view gathers from, and a look into one of them.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/room/room.h"

namespace raywalk {

// A distance map of the room and where it was captured.
struct MapStation {
  int line = -1;
  int map = -1;      // index into DistanceVolume
  int station = -1;  // the map's station on the line
  Eigen::Vector3d position_m{0, 0, 0};
};

// All distance maps of a room, line by line, in the order of the stations.
std::vector<MapStation> all_maps(const Room& room);

// Distance maps of the given lines, nearest to `viewpoint_m` first, no two nearer to each other
// than `gap_m`, at most `most_per_line` of a line and `most` in all.
std::vector<MapStation> nearest_maps(const Room& room, std::span<const int> lines,
                                     const Eigen::Vector3d& viewpoint_m, double gap_m,
                                     int most_per_line, int most);

// How the maps of a view are chosen: the last arguments of nearest_maps().
struct MapSpread {
  double gap_m = 0.0;
  int most_per_line = 0;
};

// In a cell maps are spread over its lines: of each the nearest, and one for points hidden from it.
// Where no lines close a cell, the nearest maps on both sides tell most.
MapSpread map_spread(const Grid& grid, PlanPoint viewpoint);

// Further maps of all lines, for points that masks hide from nearby stations: nearest first, each
// at least a quarter of its own distance from all others and from those in `near`, so that a few
// cover any room. At most `most`.
std::vector<MapStation> farther_maps(const Room& room, std::span<const MapStation> near,
                                     const Eigen::Vector3d& viewpoint_m, int most);

// A distance map looked up from another place.
struct MapLookup {
  float inverse_there = 0.0f;    // inverse distance of the looked-up point from the map's station
  float inverse_map = -1.0f;     // inverse distance stored in that direction; < 0 if unknown
  float inverse_around = -1.0f;  // the largest of the four pixels around that direction
};

// Looks up the point at inverse distance `inverse` in direction `direction` from `viewpoint_m` in a
// map. The map is interpolated over the pixels that agree with the point within `tolerance`; where
// none does, the nearest pixel is used.
MapLookup look_up(const Room& room, const MapStation& map, const Eigen::Vector3f& direction,
                  float inverse, const Eigen::Vector3d& viewpoint_m, float tolerance);

}  // namespace raywalk
