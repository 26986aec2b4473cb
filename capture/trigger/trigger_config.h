// The trigger section of a configuration: the GPIO lines to the camera's shutter.
// configs/capture-gpio.yaml explains every key.
#pragma once

#include <string>

namespace raywalk::capture {

// Output lines of a GPIO chip to an opto-isolated shutter, and one line back. Lines are counted
// from 0 on their chip; -1: not wired.
struct TriggerConfig {
  std::string chip = "gpiochip0";  // in /dev, or a path
  int focus_line = -1;             // half-press
  int shutter_line = -1;           // full press
  int busy_line = -1;              // from the camera: active while it is busy
  bool active_low = false;         // the two outputs
  bool busy_active_low = false;
  double focus_ms = 300.0;  // half-press before the shutter
  double pulse_ms = 100.0;  // shutter held; cameras need 10 to 100
  double hold_ms = 2000.0;  // waited after a press without a busy line
  double busy_start_timeout_ms = 2000.0;
  double busy_end_timeout_ms = 30000.0;
  // For bracketed exposures: true if the camera takes one at each press (its bracketing set to
  // single shots), false if it takes all at one press.
  bool press_per_exposure = true;
};

}  // namespace raywalk::capture
