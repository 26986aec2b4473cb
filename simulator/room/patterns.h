// The patterns of surfaces. Arguments as in albedo_at (surface.h), if not said otherwise.
#pragma once

#include "simulator/room/surface.h"

namespace raywalk::capture {

// Walls, floors and ceilings (wall_patterns.cc).
Color plaster_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color brick_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
// Exactly periodic, with `period` along s and twice that along t.
Color wallpaper_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color board_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color tile_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);

// Furniture (furnishing_patterns.cc).
Color wood_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color fabric_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color rug_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color book_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color leaf_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color lamp_emission(const Surface& surface, const Eigen::Vector2f& at, float footprint);

// A painting over `extent`, determined by the seed: hills under a sky, with discs and bars
// (picture_patterns.cc).
Color painting_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
// Light of the sky in a unit direction of the world frame (sphere.h), relative to white: a gradient
// with clouds, a bright haze at the horizon, hills below. `pixel_rad` is the angular pixel size.
Color sky_light(const Eigen::Vector3d& direction, float pixel_rad, std::uint32_t seed);

}  // namespace raywalk::capture
