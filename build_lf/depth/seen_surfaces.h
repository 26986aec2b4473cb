// The surfaces of one station's map as another station sees them.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "build_lf/depth/pixel_directions.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {

// `inverse` holds inverse distances, 1/m, of a map of `size`, [theta][phi]; negative: none.
// `towards_m` is the position of the station that sees them less that of the map's, metres, world
// axes. Returns the inverse distances of the nearest surface in each of its pixels, of `size` too;
// negative: none.
std::vector<float> seen_surfaces(std::span<const float> inverse, PanoramaSize size,
                                 const PixelDirections& directions,
                                 const Eigen::Vector3f& towards_m);

}  // namespace raywalk::build_lf
