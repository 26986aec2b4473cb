// Supervises one move: in progress, settled or failed.
#pragma once

#include <optional>
#include <string>

#include "capture/base/clock.h"
#include "capture/slider/carriage.h"
#include "capture/slider/dwell.h"
#include "capture/slider/slider.h"

namespace raywalk::capture {

// Throws DeviceFault kAlarm, with the alarm's code, if the drive cannot move: alarm or motor not
// enabled.
void require_able_to_move(const SliderState& state, const std::string& slider);

class MotionWatch {
 public:
  // `start` is the reading before the command, `now` the time of the command.
  MotionWatch(std::string slider, const SliderState& start, double target_mm,
              const SoftLimits& limits, const MotionRules& rules, SteadyTime now);

  // Whether the position is off the path from start to target by more than the following error, or
  // outside the soft limits by more than the tolerance (a move from outside back in is allowed). A
  // single such reading may be damaged; the second in a row is passed to take().
  bool is_off_course(const SliderState& state) const;
  // Takes one reading. Throws DeviceFault: kAlarm, kLimitSwitch, kFollowingError, kStall, kTimeout.
  void take(const SliderState& state, SteadyTime now);
  // For a reading that the next one did not confirm: restarts the dwell.
  void take_outlier() { dwell_.start_over(); }

  // The result once, throughout the dwell, the feedback was within the tolerance of the target and
  // the drive did not report motion or being out of position (where it reports these); else none.
  std::optional<SettledPosition> settled() const;

 private:
  struct LimitSwitch {
    const char* name;
    bool may_be_on;  // closed at the start of a move away from it, and not opened since
  };

  void check_switch(LimitSwitch* limit, std::optional<bool> on, double position_mm) const;
  bool is_outside(double position_mm) const;
  bool is_off_path(double position_mm) const;
  void check_path(double position_mm) const;
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
  double nearest_mm_;  // least distance to the target so far, at the last progress
  double previous_distance_mm_;
  SteadyTime progress_at_;
  bool has_moved_ = false;
  std::optional<SteadyTime> arrived_at_{};
  Dwell dwell_;
  SteadyTime latest_{};
};

}  // namespace raywalk::capture
