// Plots of a scene's distances by direction, as <svg> elements that follow the reader's light or
// dark mode.
#pragma once

#include <string>

#include "core/room/requirements.h"

namespace raywalk::build_lf {

// The nearest surface of every field of directions as a panorama: colour and number, metres. Fields
// of sky are labelled.
std::string direction_map_svg(const DistanceFacts& distance);

// Near, median and far distances around the horizon, seen from above, front (+z) up.
std::string horizon_svg(const DistanceFacts& distance);

}  // namespace raywalk::build_lf
