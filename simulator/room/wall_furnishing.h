// The shell of a room, and objects built into it or hanging on its walls.
#pragma once

#include "simulator/room/facets.h"
#include "simulator/room/free_space.h"
#include "simulator/room/light_sources.h"

namespace raywalk::capture {

// Floor, ceiling and walls with random surfaces: plaster, bricks, boards or tiles; ceiling and
// walls that `contents` wants plain have a uniform colour.
void add_shell(const RoomPlan& plan, const ContentSettings& contents, HashRandom random,
               Facets* facets);

// Boards along the foot of all walls.
void add_skirting(const RoomPlan& plan, HashRandom random, Facets* facets);

// A box on a wall between two corners (s, t, depth), where s and t are as in Wall and depth is
// towards the viewer; its back is left open.
void add_on_wall(const Wall& wall, const Eigen::Vector3d& min, const Eigen::Vector3d& max,
                 int surface, Facets* facets);

// Beams under the ceiling across the room's shorter side, at most 0.16 high.
void add_beams(const RoomPlan& plan, HashRandom random, Facets* facets);

// A window with frame and bars onto the sky, on the given wall. With `sun`, sunlight falls through
// it onto the floor.
WindowLight add_window(const RoomPlan& plan, int wall, bool sun, FreeSpace* space,
                       HashRandom random, Facets* facets);

// Framed, on the given wall.
void add_mirror(const RoomPlan& plan, int wall, FreeSpace* space, HashRandom random,
                Facets* facets);

// Thin panels: one from floor to ceiling with an exactly periodic pattern, one of uniform colour.
void add_wallpaper(const RoomPlan& plan, int wall, FreeSpace* space, HashRandom random,
                   Facets* facets);
void add_plain_patch(const RoomPlan& plan, int wall, FreeSpace* space, HashRandom random,
                     Facets* facets);

// Framed paintings on any wall. This and the four functions above throw UsageError naming the seed
// if there is no space left.
void add_pictures(const RoomPlan& plan, int count, FreeSpace* space, HashRandom random,
                  Facets* facets);

}  // namespace raywalk::capture
