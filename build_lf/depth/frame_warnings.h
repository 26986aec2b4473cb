// What is wrong with frames and lines, in words for the person who captured them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/frame_checks.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// One sentence for each finding: what it is, which files, and what is done about it.
std::vector<std::string> warnings_of(const Room& room, const FrameChecks& checks);

// One sentence for each line whose maps show next to no parallax, which a camera that stands still
// sees as well: its frames differ by noise only, and all of them alike. `maps` follow one another
// by line; what is nearer than `far_m` moves by a pixel or more over the reach.
std::vector<std::string> parallax_warnings(std::span<const MapSummary> maps, double far_m);

}  // namespace raywalk::build_lf
