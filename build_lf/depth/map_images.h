// Of distance maps the images that the report of a depth run shows.
#pragma once

#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/report/report.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Of each map the panorama, its inverse distances and their confidence, in the section "maps".
std::vector<ReportImage> map_images(const Room& room, const std::vector<InverseDistanceMap>& maps);

}  // namespace raywalk::build_lf
