// For tests: a configuration to plan.
#pragma once

#include "capture/config/capture_config.h"

namespace raywalk::capture {

// One cell of 1 m, stations 50 mm apart, on a rail of 2 m.
inline CaptureConfig one_cell_config() {
  CaptureConfig config;
  config.grid.spacing_mm = 50.0;
  config.slider.high_limit_mm = 2000.0;
  return config;
}

}  // namespace raywalk::capture
