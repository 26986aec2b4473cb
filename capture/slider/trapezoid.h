// The trapezoidal velocity profile of a move: accelerate, cruise, decelerate.
#pragma once

#include "capture/slider/slider.h"

namespace raywalk::capture {

// A move from rest to rest with constant acceleration, a top speed, and the same deceleration.
class Trapezoid {
 public:
  // distance_mm >= 0; speed and acceleration of the profile > 0.
  Trapezoid(double distance_mm, const MotionProfile& profile);

  double duration_ms() const { return 2.0 * ramp_ms_ + cruise_ms_; }
  // Distance travelled `ms` after the start: 0 before it, the whole distance after the end.
  double travelled_mm(double ms) const;
  double speed_mm_s(double ms) const;

 private:
  double distance_mm_;
  double acceleration_mm_s2_;
  double peak_mm_s_;
  double ramp_ms_;
  double cruise_ms_;
};

// Time to decelerate from the profile's speed to rest.
double stopping_ms(const MotionProfile& profile);

}  // namespace raywalk::capture
