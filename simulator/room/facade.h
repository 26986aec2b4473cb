// The front of a building along a street. Room units.
#pragma once

#include "simulator/room/facets.h"
#include "simulator/room/free_space.h"

namespace raywalk::capture {

// Adds a building whose front covers `front`: rows of recessed windows with sills and bars, a door
// and shop windows at the foot, ledges between storeys, a cornice, in some storeys balconies with
// railings of thin bars, and behind it flanks and a flat roof. Its walls are bricks, plaster or
// plain paint. `glass` receives the windows' panes in front of what is behind them; null: the panes
// are left out.
void add_building(const Wall& front, HashRandom random, Facets* facets, Facets* glass);

}  // namespace raywalk::capture
