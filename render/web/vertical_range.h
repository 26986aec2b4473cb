// How far the eye may move up and down.
#pragma once

#include "core/room/room.h"

namespace raywalk::render {

// The largest height above or below the stations, metres, in [0, 0.5], up to which the part of a
// view that no distance map sees grows by at most one hundredth of the view's pixels: in steps of
// 0.05 m, at the centres of at most nine cells, the smallest of these. What is not seen from the
// stations' height is stretched from its surroundings there. 0 in a room without distances or
// cells. Throws Interrupted.
double vertical_range_m(const Room& room, int distance_maps);

}  // namespace raywalk::render
