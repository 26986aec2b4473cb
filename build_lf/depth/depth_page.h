// The report of a depth run: pictures of distance and confidence, plots, warnings.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/report/html_page.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Of each map the panorama, its distances and their confidence.
using MapPictures = std::vector<std::vector<HtmlFigure>>;
MapPictures map_pictures(const Room& room, const std::vector<InverseDistanceMap>& maps);

// A self-contained HTML page. `document`: of depth.json; `pictures`: of the maps to show.
std::string depth_page(const nlohmann::ordered_json& document, const MapPictures& pictures);

}  // namespace raywalk::build_lf
