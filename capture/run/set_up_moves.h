// Moving the slider by hand, for setting up: home, jog, stop.
#pragma once

#include <string>

#include "capture/slider/slider_config.h"

namespace raywalk::capture {

// Each opens the slider, moves within its soft limits and returns one line with the position of the
// carriage. Throw DeviceFault with the slider stopped, and Interrupted.
std::string home_slider(const SliderConfig& config);
// Moves by `mm`. Throws Error if the drive is not homed, and UsageError if the move would leave the
// soft limits.
std::string jog_slider(const SliderConfig& config, double mm);
// Decelerates to a stop, also a motion that another program started.
std::string stop_slider(const SliderConfig& config);

}  // namespace raywalk::capture
