// Pieces of furniture. Each stands on the origin of its placement with its back towards -z; colours
// and proportions are random. Their sizes are declared separately, so that space can be found
// before they are built. Room units: 1 is a metre of usual furniture.
#pragma once

#include "simulator/room/free_space.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/shapes.h"

namespace raywalk::capture {

inline constexpr double kTableHeight = 0.75;

// Size of each piece; a shelf and a pane are limited by the height of the room.
Piece chair_piece();
Piece table_piece();
Piece sofa_piece();
Piece shelf_piece(double room_height);
Piece plant_piece();
Piece coat_stand_piece();
Piece glass_piece(double room_height);

// Legs, stretchers and the spindles of the back: 17 rods 1.5 to 4 cm thick.
void add_chair(const Placement& place, HashRandom random, Facets* facets);
// A table top on four thin legs, with cups and books on it.
void add_table(const Placement& place, HashRandom random, Facets* facets);
void add_sofa(const Placement& place, HashRandom random, Facets* facets);
// Boards full of books, up to `top`.
void add_shelf(const Placement& place, double top, HashRandom random, Facets* facets);
// A pot with stems and two-sided leaves.
void add_plant(const Placement& place, HashRandom random, Facets* facets);
// A pole on three feet with hooks at about the height of the cameras.
void add_coat_stand(const Placement& place, HashRandom random, Facets* facets);
// A screen: a frame, and in it a pane that is added to `glass`. Up to `top`.
void add_glass(const Placement& place, double top, HashRandom random, Facets* facets,
               Facets* glass);
// A car of usual size along z, from its wheels on the ground at the placement's origin.
void add_car(const Placement& place, HashRandom random, Facets* facets);
// Books side by side on a board from x_min to x_max, spines towards +z.
void add_books(const Placement& place, double x_min, double x_max, double height, double depth,
               HashRandom random, Facets* facets);

}  // namespace raywalk::capture
