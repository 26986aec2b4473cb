// The room seen from above: where its surfaces are, where it was captured, and which stations are
// needed.
#pragma once

#include <string>

#include "build_lf/require/thin_room.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// An <svg> element: points of surfaces within 20 degrees of eye level as the distance maps place
// them, stations that are needed (filled) and those that may be left out (rings).
std::string floor_plan_svg(const Room& room, const KeptStations& kept);

}  // namespace raywalk::build_lf
