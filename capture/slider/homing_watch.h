// Judges the readings while the drive looks for its home switch.
#pragma once

#include <string>

#include "capture/base/clock.h"
#include "capture/slider/carriage.h"
#include "capture/slider/dwell.h"
#include "capture/slider/slider.h"

namespace raywalk::capture {

// Positions mean nothing until home has been found, and limit switches may serve as home switch, so
// neither is judged here.
class HomingWatch {
 public:
  HomingWatch(std::string slider, const SliderState& start, const MotionRules& rules,
              SteadyTime now);

  // Throws DeviceFault: kAlarm, kStall (stands still, away from home), kTimeout.
  void take(const SliderState& state, SteadyTime now);
  // Once the drive reports home, neither moves nor creeps, and its position is 0 within the
  // following error, all through the dwell. The zero of a drive that has just been switched on is
  // no home; so one that does not report home must have been seen to go farther than the following
  // error, and has to stand at 0 within the tolerance for the stall time.
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
