// A floor plan of the room: surfaces, stations, and which stations are needed.
#pragma once

#include <string>

#include "build_lf/require/thin_room.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// An <svg> element: surface points of the distance maps within 20 degrees of the horizon, stations
// that are needed (filled) and stations that can be left out (rings).
std::string floor_plan_svg(const Room& room, const KeptStations& kept);

}  // namespace raywalk::build_lf
