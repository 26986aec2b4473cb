// Findings about frames and lines as sentences for the user.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/frame_checks.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// One sentence per finding: the fault, the files, and how the run handles it.
std::vector<std::string> warnings_of(const Room& room, const FrameChecks& checks);

// One sentence per line whose maps show almost no parallax, as when the camera did not move at all:
// then all frames differ by noise only, which kNotMoved, relative to the line, cannot detect.
// `maps` are ordered by line; surfaces nearer than `far_m` move by a pixel or more over the reach.
std::vector<std::string> parallax_warnings(std::span<const MapSummary> maps, double far_m);

}  // namespace raywalk::build_lf
