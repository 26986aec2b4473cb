// Supervises a motion, a move or homing, by its readings: in progress, at its end or failed.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "capture/base/clock.h"
#include "capture/slider/carriage.h"
#include "capture/slider/slider_state.h"
#include "capture/slider/soft_limits.h"

namespace raywalk::capture {

// Throws DeviceFault kAlarm, with the alarm's code, if the drive cannot move: alarm or motor not
// enabled.
void require_able_to_move(const SliderState& state, const std::string& slider);

// Whether a condition has held for long enough, where a single reading may be wrong: over once at
// least three consecutive good readings span `length`, within `spread_mm` of one another. A reading
// may be one poll old (see ModbusLink), so fewer could all show the same moment.
class Dwell {
 public:
  explicit Dwell(Duration length, double spread_mm = std::numeric_limits<double>::infinity())
      : length_(length), spread_mm_(spread_mm) {}

  // Starts over at a bad reading, and with a good one that is too far from an earlier one.
  void take(bool good, SteadyTime time, double position_mm) {
    const double spread_mm = std::max(high_mm_, position_mm) - std::min(low_mm_, position_mm);
    if (!good || spread_mm > spread_mm_) *this = Dwell(length_, spread_mm_);
    if (!good) return;
    if (readings_++ == 0) since_ = time;
    latest_ = time;
    low_mm_ = std::min(low_mm_, position_mm);
    high_mm_ = std::max(high_mm_, position_mm);
    sum_mm_ += position_mm;
  }

  bool is_over() const { return readings_ >= kMinReadings && latest_ - since_ >= length_; }
  double mean_mm() const { return sum_mm_ / readings_; }  // there must be a reading

 private:
  static constexpr int kMinReadings = 3;

  Duration length_;
  double spread_mm_;
  SteadyTime since_{};
  SteadyTime latest_{};
  double sum_mm_ = 0.0;
  double low_mm_ = std::numeric_limits<double>::infinity();
  double high_mm_ = -std::numeric_limits<double>::infinity();
  int readings_ = 0;
};

// A command, and what it was given for.
struct Commanded {
  std::string slider{};  // for messages
  SliderState start{};   // the reading before the command
  MotionRules rules{};
  SteadyTime at{};  // the time of the command

  double moved_mm(const SliderState& state) const {
    return std::abs(state.position_mm - start.position_mm);
  }
};

// Positions are not valid before home is found, and a limit switch may serve as home switch, so
// neither is checked here.
class HomingWatch {
 public:
  explicit HomingWatch(Commanded command) : command_(std::move(command)) {}

  // Takes one reading. Throws DeviceFault: kAlarm, kStall (at rest away from home), kTimeout.
  void take(const SliderState& state, SteadyTime now);
  // True once the drive has, throughout the dwell, reported home, been at rest and shown position 0
  // within the following error. A drive that has just been switched on also shows 0. So a drive
  // without a home flag must have moved farther than the following error, and then stay at 0 within
  // the tolerance for the stall time.
  bool is_home() const { return dwell_.is_over(); }

 private:
  [[noreturn]] void fail_at_rest(const SliderState& state) const;

  Commanded command_;
  Duration dwell_time_ = duration_from_ms(
      command_.start.homed ? command_.rules.settle_ms
                           : std::max(command_.rules.settle_ms, command_.rules.stall_ms));
  double resting_mm_ = command_.start.position_mm;
  SteadyTime resting_since_ = command_.at;
  bool has_moved_ = false;
  Dwell dwell_{dwell_time_, 2.0 * command_.rules.settle_tolerance_mm};
};

class MotionWatch {
 public:
  MotionWatch(Commanded command, double target_mm, const SoftLimits& limits)
      : command_(std::move(command)), target_mm_(target_mm), limits_(limits) {}

  // Whether the position is off the path from start to target by more than the following error, or
  // outside the soft limits by more than the tolerance (a move from outside back in is allowed). A
  // single such reading may be damaged; the second in a row is passed to take().
  bool is_off_course(const SliderState& state) const;
  // Takes one reading. Throws DeviceFault: kAlarm, kLimitSwitch, kFollowingError, kStall, kTimeout.
  void take(const SliderState& state, SteadyTime now);
  // For a reading that the next one did not confirm: restarts the dwell.
  void take_outlier() { dwell_.take(false, latest_, 0.0); }

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

  Commanded command_;
  double target_mm_;
  SoftLimits limits_;
  // At the start of a move away from it, a switch may be closed.
  LimitSwitch low_{"low", command_.start.at_low_limit.value_or(false) &&
                              target_mm_ >= command_.start.position_mm};
  LimitSwitch high_{"high", command_.start.at_high_limit.value_or(false) &&
                                target_mm_ <= command_.start.position_mm};
  // Least distance to the target so far, at the last progress.
  double nearest_mm_ = std::abs(target_mm_ - command_.start.position_mm);
  double previous_distance_mm_ = nearest_mm_;
  SteadyTime progress_at_ = command_.at;
  bool has_moved_ = false;
  std::optional<SteadyTime> arrived_at_{};
  Dwell dwell_{duration_from_ms(command_.rules.settle_ms)};
  SteadyTime latest_{};
};

}  // namespace raywalk::capture
