// Judges the readings of one move: on its way, settled, or gone wrong.
#pragma once

#include <optional>
#include <string>

#include "capture/base/clock.h"
#include "capture/slider/carriage.h"
#include "capture/slider/dwell.h"
#include "capture/slider/slider.h"

namespace raywalk::capture {

// The drive is in a state that moves nothing: alarm, or motor not enabled. Throws DeviceFault
// kAlarm with the alarm's code.
void require_able_to_move(const SliderState& state, const std::string& slider);

class MotionWatch {
 public:
  // `start` is the reading before the command, `now` the time of the command.
  MotionWatch(std::string slider, const SliderState& start, double target_mm,
              const SoftLimits& limits, const MotionRules& rules, SteadyTime now);

  // Whether the position is where it has no business to be: off the way from start to target by
  // more than the following error, or outside of the soft limits by more than the tolerance (a move
  // from outside back in is allowed). One such reading may be a damaged one; two in a row are
  // passed to take().
  bool is_astray(const SliderState& state) const;
  // Takes one reading. Throws DeviceFault: kAlarm, kLimitSwitch, kFollowingError, kStall, kTimeout.
  void take(const SliderState& state, SteadyTime now);
  // A reading that another did not confirm: the dwell starts over.
  void take_outlier() { dwell_.start_over(); }

  // Once the feedback has lain within the tolerance of the target all through the dwell, with the
  // drive reporting, as far as it reports at all, that it neither moves nor is out of position.
  std::optional<SettledPosition> settled() const;

 private:
  struct LimitSwitch {
    const char* name;
    bool may_be_on;  // it was at the start, the move leaves it, and it has not opened since
  };

  void check_switch(LimitSwitch* limit, std::optional<bool> on, double position_mm) const;
  bool is_outside(double position_mm) const;
  bool is_off_way(double position_mm) const;
  void check_way(double position_mm) const;
  void follow_progress(const SliderState& state, SteadyTime now);
  void follow_dwell(const SliderState& state, SteadyTime now);
  bool is_at_target(double position_mm) const;
  [[noreturn]] void fail_without_progress(const SliderState& state) const;
  [[noreturn]] void fail_late(const SliderState& state, SteadyTime now) const;

  std::string slider_;
  double start_mm_;
  double target_mm_;
  SoftLimits limits_;
  MotionRules rules_;
  LimitSwitch low_;
  LimitSwitch high_;
  SteadyTime commanded_at_;
  SteadyTime deadline_;
  Duration stall_time_;
  double nearest_mm_;  // least distance to the target up to the last progress
  double previous_distance_mm_;
  SteadyTime progress_at_;
  bool has_moved_ = false;
  std::optional<SteadyTime> arrived_at_{};
  Dwell dwell_;
  SteadyTime latest_{};
};

}  // namespace raywalk::capture
