// What stands in the cells of a hall, and printed panels. Room units.
#pragma once

#include "simulator/room/hash_random.h"
#include "simulator/room/shapes.h"

namespace raywalk::capture {

// The place of a stand: the middle of its square on the floor.
struct StandPlace {
  Placement floor{};
  double ceiling = 2.5;        // above the floor
  double camera_height = 1.4;  // above the floor
  double side = 0.5;           // of the square that the stand stays within
};

// A shelf with goods on both sides, a column up to the ceiling, or a poster on a pole.
void add_stand(const StandPlace& place, HashRandom random, Facets* facets);

// A thin box between two corners, with a picture on its two larger sides, along x.
void add_panel(const Placement& place, const Eigen::Vector3d& min, const Eigen::Vector3d& max,
               HashRandom random, Facets* facets);

}  // namespace raywalk::capture
