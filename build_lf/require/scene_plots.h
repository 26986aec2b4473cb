// Pictures of how far a scene is in every direction, as <svg> elements for a page; they follow the
// reader's light or dark mode.
#pragma once

#include <string>

#include "core/room/requirements.h"

namespace raywalk::build_lf {

// The nearest surface of every field of directions, laid out as a panorama: colour and number, in
// metres. Fields of sky say so.
std::string direction_map_svg(const DistanceFacts& distance);

// Near, median and far distances around the horizon, seen from above, front upwards.
std::string horizon_svg(const DistanceFacts& distance);

}  // namespace raywalk::build_lf
