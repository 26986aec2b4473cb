// Patterns of walls, floors and ceilings. All take texture coordinates and footprint as albedo_at
// (surface.h) does.
#pragma once

#include "capture/simulated/virtual_room/surface.h"

namespace raywalk::capture {

Color plaster_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color brick_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
// Exactly periodic: by `period` along s and by twice that along t.
Color wallpaper_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color board_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color tile_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);

}  // namespace raywalk::capture
