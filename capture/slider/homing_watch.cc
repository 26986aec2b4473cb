#include "capture/slider/homing_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/base/device_fault.h"
#include "capture/slider/motion_watch.h"

namespace raywalk::capture {
namespace {

double dwell_ms(const SliderState& state, const MotionRules& rules) {
  return state.homed ? rules.settle_ms : std::max(rules.settle_ms, rules.stall_ms);
}

// Longer than the dwell, so that a drive at home without a home flag is not reported as stalled.
double stall_ms(const SliderState& state, const MotionRules& rules) {
  return dwell_ms(state, rules) + rules.stall_ms;
}

}  // namespace

HomingWatch::HomingWatch(std::string slider, const SliderState& start, const MotionRules& rules,
                         SteadyTime now)
    : slider_(std::move(slider)),
      rules_(rules),
      deadline_(now + duration_from_ms(rules.homing_timeout_ms)),
      resting_mm_(start.position_mm),
      start_mm_(start.position_mm),
      resting_since_(now),
      dwell_(duration_from_ms(dwell_ms(start, rules))) {}

void HomingWatch::take(const SliderState& state, SteadyTime now) {
  require_able_to_move(state, slider_);
  follow_motion(state, now);
  follow_dwell(state, now);
  if (is_home()) return;
  if (now - resting_since_ > duration_from_ms(stall_ms(state, rules_))) fail_at_rest(state);
  if (now > deadline_) {
    throw DeviceFault(FaultKind::kTimeout,
                      fmt::format("{}: not home after {:g} s; check the home switch, or raise "
                                  "homing_timeout_ms",
                                  slider_, rules_.homing_timeout_ms / 1e3));
  }
}

void HomingWatch::follow_motion(const SliderState& state, SteadyTime now) {
  if (std::abs(state.position_mm - start_mm_) > rules_.following_error_mm) has_moved_ = true;
  if (std::abs(state.position_mm - resting_mm_) <= rules_.settle_tolerance_mm) return;
  resting_mm_ = state.position_mm;
  resting_since_ = now;
}

void HomingWatch::follow_dwell(const SliderState& state, SteadyTime now) {
  const double zero_mm = state.homed ? rules_.following_error_mm : rules_.settle_tolerance_mm;
  const bool at_home = state.homed.value_or(has_moved_) && !state.moving.value_or(false) &&
                       std::abs(state.position_mm) <= zero_mm;
  const bool creeps = !dwell_.is_empty() &&
                      dwell_.spread_with_mm(state.position_mm) > 2.0 * rules_.settle_tolerance_mm;
  if (!at_home || creeps) dwell_.start_over();
  if (at_home) dwell_.add(now, state.position_mm);
}

void HomingWatch::fail_at_rest(const SliderState& state) const {
  const char* remedy = state.homed || has_moved_
                           ? "check the home switch and what blocks the carriage"
                           : "check what blocks the carriage; if it is on its home switch and the "
                             "drive has no home flag, jog it away first";
  throw DeviceFault(FaultKind::kStall,
                    fmt::format("{}: at rest at {:.3f} mm without having found home; {}", slider_,
                                state.position_mm, remedy));
}

}  // namespace raywalk::capture
