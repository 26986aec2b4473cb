// A distance map at the width of a developed picture.
#pragma once

#include "core/room/omega_map.h"

namespace raywalk::build_lf {

// The map at another, larger width: inverse distances are interpolated between neighbours on one
// surface (resized), and steps, which would be stairs of the map's pixels, are smoothed by medians
// that leave what is a pixel of the map wide.
OmegaMap enlarged(const OmegaMap& map, int width);

}  // namespace raywalk::build_lf
