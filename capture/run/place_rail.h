// Placing the rail at the next line: the slider has one axis, so each line of a grid needs its own
// placement, or several if it is longer than the rail.
#pragma once

#include <functional>
#include <string>

#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

// One line of text that says where to place the rail for a placement (placements_of of
// capture_plan.h). `number` of `count` placements, from 1.
std::string placement_text(const CaptureLine& line, int number, int count);

// Returns when the rail is at the stations of `line`, one placement, the given one of `count`.
// Throws Error if it cannot be placed, and Interrupted.
using PlaceRail = std::function<void(const CaptureLine& line, int number, int count)>;

// A PlaceRail for a configuration. If `config.place_url` is set, the rig places the rail itself on
// an HTTP POST of {"line": ..., "placement": number on the line from 1, "start_m": [x, z], "end_m":
// [x, z]} (metres, world frame). Otherwise, with `yes`, the rail is taken to be in place; without
// it, the operator is told where to place it and presses Enter.
void place_rail(const RunConfig& config, bool yes, const CaptureLine& line, int number, int count);

}  // namespace raywalk::capture
