#include "capture/slider/motion_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/base/device_fault.h"

namespace raywalk::capture {
namespace {

double distance_to_range(double value, double low, double high) {
  return std::max({0.0, low - value, value - high});
}

}  // namespace

void require_able_to_move(const SliderState& state, const std::string& slider) {
  if (state.alarm) {
    throw DeviceFault(FaultKind::kAlarm,
                      fmt::format("{}: alarm {} at {:.3f} mm; see the drive's manual, clear its "
                                  "cause, and home again",
                                  slider, state.alarm_code, state.position_mm));
  }
  if (!state.enabled.value_or(true)) {
    throw DeviceFault(FaultKind::kAlarm,
                      fmt::format("{}: the motor is not enabled; release the emergency stop, or "
                                  "enable it at the drive",
                                  slider));
  }
}

void HomingWatch::take(const SliderState& state, SteadyTime now) {
  require_able_to_move(state, command_.slider);
  if (command_.moved_mm(state) > command_.rules.following_error_mm) has_moved_ = true;
  if (std::abs(state.position_mm - resting_mm_) > command_.rules.settle_tolerance_mm) {
    resting_mm_ = state.position_mm;
    resting_since_ = now;
  }
  const double zero_mm =
      state.homed ? command_.rules.following_error_mm : command_.rules.settle_tolerance_mm;
  const bool at_home = state.homed.value_or(has_moved_) && !state.moving.value_or(false) &&
                       std::abs(state.position_mm) <= zero_mm;
  dwell_.take(at_home, now, state.position_mm);
  if (is_home()) return;
  // Longer than the dwell, so that a drive at home without a home flag is not reported as stalled.
  if (now - resting_since_ > dwell_time_ + duration_from_ms(command_.rules.stall_ms))
    fail_at_rest(state);
  if (now - command_.at > duration_from_ms(command_.rules.homing_timeout_ms)) {
    throw DeviceFault(FaultKind::kTimeout,
                      fmt::format("{}: not home after {:g} s; check the home switch, or raise "
                                  "homing_timeout_ms",
                                  command_.slider, command_.rules.homing_timeout_ms / 1e3));
  }
}

void HomingWatch::fail_at_rest(const SliderState& state) const {
  const char* remedy = state.homed || has_moved_
                           ? "check the home switch and what blocks the carriage"
                           : "check what blocks the carriage; if it is on its home switch and the "
                             "drive has no home flag, jog it away first";
  throw DeviceFault(FaultKind::kStall,
                    fmt::format("{}: at rest at {:.3f} mm without having found home; {}",
                                command_.slider, state.position_mm, remedy));
}

bool MotionWatch::is_outside(double position_mm) const {
  return distance_to_range(position_mm, std::min(command_.start.position_mm, limits_.low_mm()),
                           std::max(command_.start.position_mm, limits_.high_mm())) >
         command_.rules.settle_tolerance_mm;
}

bool MotionWatch::is_off_path(double position_mm) const {
  return distance_to_range(position_mm, std::min(command_.start.position_mm, target_mm_),
                           std::max(command_.start.position_mm, target_mm_)) >
         command_.rules.following_error_mm;
}

bool MotionWatch::is_off_course(const SliderState& state) const {
  return is_outside(state.position_mm) || is_off_path(state.position_mm);
}

void MotionWatch::take(const SliderState& state, SteadyTime now) {
  latest_ = now;
  require_able_to_move(state, command_.slider);
  check_switch(&low_, state.at_low_limit, state.position_mm);
  check_switch(&high_, state.at_high_limit, state.position_mm);
  check_path(state.position_mm);
  follow_dwell(state, now);
  if (dwell_.is_over()) return;
  follow_progress(state, now);
  // The duration of the move's trapezoid, its dwell and some more.
  const double most_ms =
      command_.rules.profile.moving_ms(std::abs(target_mm_ - command_.start.position_mm)) +
      command_.rules.settle_ms + command_.rules.settle_timeout_ms;
  if (now - command_.at > duration_from_ms(most_ms)) fail_late(state, now);
}

std::optional<SettledPosition> MotionWatch::settled() const {
  if (!dwell_.is_over()) return std::nullopt;
  return SettledPosition{target_mm_, dwell_.mean_mm(), ms_from_duration(*arrived_at_ - command_.at),
                         ms_from_duration(latest_ - *arrived_at_), latest_};
}

void MotionWatch::check_switch(LimitSwitch* limit, std::optional<bool> on,
                               double position_mm) const {
  if (!on.value_or(false)) {
    limit->may_be_on = false;
    return;
  }
  if (limit->may_be_on) return;
  throw DeviceFault(
      FaultKind::kLimitSwitch,
      fmt::format("{}: {} limit switch at {:.3f} mm on the way to {:.3f} mm; check the "
                  "rail, then home again",
                  command_.slider, limit->name, position_mm, target_mm_));
}

void MotionWatch::check_path(double position_mm) const {
  if (is_outside(position_mm)) {
    throw DeviceFault(
        FaultKind::kLimitSwitch,
        fmt::format("{}: at {:.3f} mm, outside the soft limits {:g} to {:g} mm; check "
                    "the rail, then home again",
                    command_.slider, position_mm, limits_.low_mm(), limits_.high_mm()));
  }
  if (is_off_path(position_mm)) {
    throw DeviceFault(
        FaultKind::kFollowingError,
        fmt::format("{}: at {:.3f} mm, off the path from {:.3f} to {:.3f} mm; check "
                    "the rail and the belt, then home again",
                    command_.slider, position_mm, command_.start.position_mm, target_mm_));
  }
}

bool MotionWatch::is_at_target(double position_mm) const {
  return std::abs(position_mm - target_mm_) <= command_.rules.settle_tolerance_mm;
}

void MotionWatch::follow_dwell(const SliderState& state, SteadyTime now) {
  const bool arrived = is_at_target(state.position_mm);
  if (arrived && !arrived_at_) arrived_at_ = now;
  const bool at_rest = !state.moving.value_or(false) && state.in_position.value_or(true);
  dwell_.take(arrived && at_rest, now, state.position_mm);
}

// Progress is the lesser of two consecutive readings: otherwise one wrong reading near the target
// would make all later ones look like no progress. A step by one tolerance takes at most the
// duration of a trapezoid of that length from rest; the stall time is added to it, so that a slow
// pass is not taken for a stall.
void MotionWatch::follow_progress(const SliderState& state, SteadyTime now) {
  const double distance_mm = std::abs(state.position_mm - target_mm_);
  const double reached_mm = std::max(distance_mm, previous_distance_mm_);
  previous_distance_mm_ = distance_mm;
  if (reached_mm <= nearest_mm_ - command_.rules.settle_tolerance_mm) {
    nearest_mm_ = reached_mm;
    progress_at_ = now;
    has_moved_ = true;
  }
  if (is_at_target(state.position_mm)) progress_at_ = now;
  const double most_ms = command_.rules.stall_ms +
                         command_.rules.profile.moving_ms(command_.rules.settle_tolerance_mm);
  if (now - progress_at_ > duration_from_ms(most_ms)) fail_without_progress(state);
}

void MotionWatch::fail_without_progress(const SliderState& state) const {
  const bool drive_is_done = !state.moving.value_or(true) || state.in_position.value_or(false);
  if (has_moved_ && drive_is_done) {
    throw DeviceFault(
        FaultKind::kFollowingError,
        fmt::format("{}: stopped at {:.3f} mm, {:.3f} mm off its target {:.3f} mm; check what "
                    "blocks the carriage, then home again",
                    command_.slider, state.position_mm, std::abs(state.position_mm - target_mm_),
                    target_mm_));
  }
  throw DeviceFault(FaultKind::kStall,
                    fmt::format("{}: {} at {:.3f} mm on the way to {:.3f} mm; check what blocks "
                                "the carriage, then home again",
                                command_.slider, has_moved_ ? "stalled" : "does not move",
                                state.position_mm, target_mm_));
}

void MotionWatch::fail_late(const SliderState& state, SteadyTime now) const {
  const char* lacking = !is_at_target(state.position_mm)    ? "has not arrived"
                        : state.moving.value_or(false)      ? "still reports a motion"
                        : !state.in_position.value_or(true) ? "reports being out of position"
                                                            : "does not come to rest";
  throw DeviceFault(FaultKind::kTimeout,
                    fmt::format("{}: {} {:.1f} s after the command to go to {:.3f} mm, at {:.3f} "
                                "mm; check speeds and tuning, or raise settle_timeout_ms",
                                command_.slider, lacking, ms_from_duration(now - command_.at) / 1e3,
                                target_mm_, state.position_mm));
}

}  // namespace raywalk::capture
