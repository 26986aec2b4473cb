// The report of a depth run: pictures of distance and confidence, plots, warnings.
#pragma once

#include <string>
#include <vector>

#include "build_lf/depth/depth_summary.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A self-contained HTML page. `shown` are the maps to show, one per line.
std::string depth_page(const Room& room, const DepthSummary& summary,
                       const std::vector<InverseDistanceMap>& shown);

}  // namespace raywalk::build_lf
