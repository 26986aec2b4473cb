// Who brings the rail to the next line. The slider is one axis: a grid is many placements.
#pragma once

#include <memory>
#include <string>

#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

// Where the rail belongs for a line, as one line for people. `number` of `count` lines, from 1.
std::string placement_text(const CaptureLine& line, int number, int count);

class RailPlacer {
 public:
  virtual ~RailPlacer() = default;

  // Returns when the rail lies at the line. Throws Error where nobody places it, and Interrupted.
  virtual void place(const CaptureLine& line, int number, int count) = 0;
};

// Who places the rail: the rig itself, told by HTTP POST of {"line": ..., "start_m": [x, z],
// "end_m": [x, z]}, where `config.place_url` is set; nobody, with `yes`; else the operator, who is
// told where and presses Enter.
std::unique_ptr<RailPlacer> make_rail_placer(const RunConfig& config, bool yes);

}  // namespace raywalk::capture
