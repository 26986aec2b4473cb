// Supervises homing: checks the readings while the drive searches for its home switch.
#pragma once

#include <string>

#include "capture/base/clock.h"
#include "capture/slider/carriage.h"
#include "capture/slider/dwell.h"
#include "capture/slider/slider.h"

namespace raywalk::capture {

// Positions are not valid before home is found, and a limit switch may serve as home switch, so
// neither is checked here.
class HomingWatch {
 public:
  HomingWatch(std::string slider, const SliderState& start, const MotionRules& rules,
              SteadyTime now);

  // Takes one reading. Throws DeviceFault: kAlarm, kStall (at rest away from home), kTimeout.
  void take(const SliderState& state, SteadyTime now);
  // True once the drive has, throughout the dwell, reported home, been at rest and shown position 0
  // within the following error. A drive that has just been switched on also shows 0. So a drive
  // without a home flag must have moved farther than the following error, and then stay at 0 within
  // the tolerance for the stall time.
  bool is_home() const { return dwell_.is_over(); }

 private:
  void follow_dwell(const SliderState& state, SteadyTime now);
  void follow_motion(const SliderState& state, SteadyTime now);
  [[noreturn]] void fail_at_rest(const SliderState& state) const;

  std::string slider_;
  MotionRules rules_;
  SteadyTime deadline_;
  double resting_mm_;
  double start_mm_;
  bool has_moved_ = false;
  SteadyTime resting_since_;
  Dwell dwell_;
};

}  // namespace raywalk::capture
