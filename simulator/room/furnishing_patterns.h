// Patterns of furniture. Arguments as in albedo_at (surface.h).
#pragma once

#include "simulator/room/surface.h"

namespace raywalk::capture {

Color wood_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color fabric_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color rug_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color book_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color leaf_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint);
Color lamp_emission(const Surface& surface, const Eigen::Vector2f& at, float footprint);

}  // namespace raywalk::capture
