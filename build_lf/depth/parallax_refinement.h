// Refinement of distances below the step of the sweep's layers.
#pragma once

#include "build_lf/depth/tile_views.h"

namespace raywalk::build_lf {

// Moves every known pixel of the map to where the stations' colours agree best nearby, by steps of
// Gauss and Newton (Lucas and Kanade 1981, along the epipolar curve): with e the difference of the
// reference's luminance from what a station shows of the pixel's point, and g how the latter
// changes with inverse distance, omega grows by sum(w g e) / sum(w g^2) over the stations and over
// the 5 x 5 pixels of the same surface around. w falls with e, so a station from which the point is
// hidden does not count. A step is at most half a pixel of parallax at `reach_m`, and small where
// there is little to see.
void refine_parallax(const TileViews& views, double reach_m, InverseDistanceMap* map);

}  // namespace raywalk::build_lf
