// Patterns of walls, floors and ceilings. Arguments as in albedo_at (surface.h).
#pragma once

#include "simulator/room/surface.h"

namespace raywalk::capture {

Color plaster_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color brick_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
// Exactly periodic, with `period` along s and twice that along t.
Color wallpaper_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color board_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color tile_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);

}  // namespace raywalk::capture
