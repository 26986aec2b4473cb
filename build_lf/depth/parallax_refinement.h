// Refinement of distances to less than the sweep's layer step.
#pragma once

#include "build_lf/depth/tile_views.h"

namespace raywalk::build_lf {

// Refines every known pixel of the map by Gauss-Newton steps (Lucas and Kanade 1981, along the
// epipolar curve). With e the reference's luminance minus that of the pixel's point in a station's
// picture, and g the derivative of the latter with respect to inverse distance, omega increases by
// sum(w g e) / sum(w g^2) over the stations and the 5 x 5 neighbours on the same surface. w
// decreases with e, so stations in which the point is occluded have little weight. A step is at
// most half a pixel of parallax at `reach_m`, and damped where there is little texture.
void refine_parallax(const TileViews& views, double reach_m, InverseDistanceMap* map);

}  // namespace raywalk::build_lf
