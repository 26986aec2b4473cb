// Patterns of paintings and of the sky outside the window.
#pragma once

#include "simulator/room/surface.h"

namespace raywalk::capture {

// A painting over `extent`, determined by the seed: hills under a sky, with discs and bars.
// Arguments as in albedo_at (surface.h).
Color painting_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);

// Light of the sky in a unit direction of the world frame (sphere.h), relative to white: a gradient
// with clouds, a bright haze at the horizon, hills below. `pixel_rad` is the angular pixel size.
Color sky_light(const Eigen::Vector3d& direction, float pixel_rad, std::uint32_t seed);

}  // namespace raywalk::capture
