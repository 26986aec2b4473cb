// All distance maps of a room.
#pragma once

#include <vector>

#include "core/room/room.h"
#include "core/view/map_choice.h"

namespace raywalk::build_lf {

// Line by line, in the order of the stations.
std::vector<MapStation> all_maps(const Room& room);

}  // namespace raywalk::build_lf
