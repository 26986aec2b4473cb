// How a carriage is moved along a rail, and what its drive reports.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "capture/base/units.h"

namespace raywalk::capture {

// The top speed and the acceleration, which is the deceleration too, of moves from rest to rest.
struct MotionProfile {
  double speed_mm_s = 100.0;
  double acceleration_mm_s2 = 200.0;

  // From the top speed to rest.
  double stopping_ms() const { return kMsPerSecond * speed_mm_s / acceleration_mm_s2; }
  // A ramp to speed v takes the time v/a and the distance v^2/(2a). Both ramps fit in the distance
  // d if v^2/a <= d; otherwise the greatest speed is sqrt(a d). distance_mm >= 0.
  double moving_ms(double distance_mm) const {
    const double peak_mm_s = std::min(speed_mm_s, std::sqrt(acceleration_mm_s2 * distance_mm));
    if (peak_mm_s <= 0.0) return 0.0;
    return kMsPerSecond * (peak_mm_s / acceleration_mm_s2 + distance_mm / peak_mm_s);
  }
};

// The state that the drive reports in one reading. Flags that it does not report are none.
struct SliderState {
  double position_mm = 0.0;  // feedback, from home
  bool alarm = false;
  int alarm_code = 0;  // as in the drive's manual; 0 if unknown
  std::optional<bool> enabled{};
  std::optional<bool> homed{};
  std::optional<bool> moving{};
  std::optional<bool> in_position{};
  std::optional<bool> at_low_limit{};  // limit switches
  std::optional<bool> at_high_limit{};
};

}  // namespace raywalk::capture
