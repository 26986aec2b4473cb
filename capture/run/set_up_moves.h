// Moving the slider by hand, for setting up: home, jog, stop.
#pragma once

#include <string>

#include "capture/slider/slider_config.h"

namespace raywalk::capture {

// Each opens the slider, moves inside of its soft limits and returns one line that says where the
// carriage is now. Throw DeviceFault with the slider stopped, and Interrupted.
std::string home_slider(const SliderConfig& config);
// By `mm` from where it is, which it has to know: throws Error where the drive is not homed, and
// UsageError where the move would leave the soft limits.
std::string jog_slider(const SliderConfig& config, double mm);
// At once and decelerated, whoever moved it.
std::string stop_slider(const SliderConfig& config);

}  // namespace raywalk::capture
