#include "capture/slider/carriage.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <exception>

#include "capture/base/device_fault.h"
#include "capture/slider/modbus_slider.h"
#include "capture/slider/motion_watch.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

// Each sends the command, which has its own retries, and waits for standstill.
constexpr int kStopAttempts = 2;
constexpr int kStartReadings = 5;

}  // namespace

struct Carriage::StopOutcome {
  bool confirmed = false;
  double position_mm = 0.0;
  FaultKind kind = FaultKind::kTimeout;
  std::string why_not{};

  std::string text() const {
    return confirmed ? fmt::format(" (stopped at {:.3f} mm)", position_mm)
                     : " (NOT known to have stopped: switch the drive off; " + why_not + ")";
  }
};

Carriage::Carriage(ModbusSlider* slider, Clock* clock, const SoftLimits& limits,
                   const MotionRules& rules)
    : slider_(slider), clock_(clock), limits_(limits), rules_(rules) {
  latest_profile_ = rules.profile;
}

Carriage::~Carriage() {
  if (!may_be_moving_) return;
  try {
    const StopOutcome outcome = bring_to_rest();
    if (!outcome.confirmed) spdlog::error("{}{}", slider_->description(), outcome.text());
  } catch (const std::exception& error) {
    spdlog::error("{}: cannot stop: {}", slider_->description(), error.what());
  }
}

// Runs a motion and stops the carriage if it throws, so that it never keeps moving unnoticed.
template <typename Motion>
auto Carriage::supervise(const Motion& motion) {
  may_be_moving_ = true;
  try {
    auto result = motion();
    may_be_moving_ = false;
    return result;
  } catch (const DeviceFault& fault) {
    const StopOutcome outcome = bring_to_rest();
    throw DeviceFault(fault.kind(), fault.what() + outcome.text());
  } catch (const Interrupted&) {
    stop();
    throw;
  } catch (...) {
    const StopOutcome outcome = bring_to_rest();
    if (!outcome.confirmed) spdlog::error("{}{}", slider_->description(), outcome.text());
    throw;
  }
}

void Carriage::home() {
  const SliderState start = ready_to_move();
  supervise([&] {
    slider_->start_homing();
    HomingWatch watch({slider_->description(), start, rules_, clock_->now()});
    for (;;) {
      throw_if_interrupted();
      const SliderState state = read();
      watch.take(state, clock_->now());
      if (watch.is_home()) return true;
      pause();
    }
  });
}

SettledPosition Carriage::move_to(SafePosition target) { return move_to(target, rules_.profile); }

SettledPosition Carriage::move_to(SafePosition target, const MotionProfile& profile) {
  const SliderState start = ready_to_move();
  if (!start.homed.value_or(true)) {
    throw DeviceFault(FaultKind::kAlarm, slider_->description() +
                                             ": the drive has not been homed since it was switched "
                                             "on, so its positions are not valid; home first");
  }
  MotionRules rules = rules_;
  rules.profile = profile;
  latest_profile_ = profile;
  return supervise([&] {
    slider_->start_move(target, profile);
    MotionWatch watch({slider_->description(), start, rules, clock_->now()}, target.mm(), limits_);
    for (;;) {
      throw_if_interrupted();
      SliderState state = read();
      if (watch.is_off_course(state)) {
        state = read();
        if (!watch.is_off_course(state)) watch.take_outlier();
      }
      watch.take(state, clock_->now());
      if (const auto settled = watch.settled()) return *settled;
      pause();
    }
  });
}

void Carriage::stop() {
  const StopOutcome outcome = bring_to_rest();
  if (!outcome.confirmed) {
    throw DeviceFault(outcome.kind, slider_->description() + ": stop" + outcome.text());
  }
}

SliderState Carriage::read() {
  const SliderState state = slider_->read_state();
  if (watch_) watch_(clock_->wall_now(), state.position_mm);
  return state;
}

// Stops a motion that another program started, for example one killed during a move.
SliderState Carriage::ready_to_move() {
  throw_if_interrupted();
  SliderState state = read_start();
  require_able_to_move(state, slider_->description());
  if (state.moving.value_or(false)) {
    stop();
    state = read_start();
  }
  return state;
}

// The path is checked from the start position, which must not be a single damaged reading: returns
// the second of two readings that agree. The caller stops a carriage in motion and reads again.
SliderState Carriage::read_start() {
  SliderState before = read();
  for (int reading = 1; reading < kStartReadings; ++reading) {
    const SliderState state = read();
    const bool agree =
        std::abs(state.position_mm - before.position_mm) <= rules_.following_error_mm;
    if (agree || state.moving.value_or(false)) return state;
    before = state;
  }
  throw DeviceFault(
      FaultKind::kFollowingError,
      fmt::format("{}: the position jumps although the carriage is at rest, last {:.3f} "
                  "mm; check the encoder and the cable",
                  slider_->description(), before.position_mm));
}

Carriage::StopOutcome Carriage::bring_to_rest() {
  StopOutcome outcome;
  for (int attempt = 0; attempt < kStopAttempts; ++attempt) {
    try {
      slider_->stop();
      if (comes_to_rest(&outcome.position_mm)) {
        outcome.confirmed = true;
        may_be_moving_ = false;
        return outcome;
      }
      outcome.kind = FaultKind::kTimeout;
      outcome.why_not = fmt::format("still moving, at {:.3f} mm", outcome.position_mm);
    } catch (const DeviceFault& fault) {
      outcome.kind = fault.kind();
      outcome.why_not = fault.what();
    }
  }
  return outcome;
}

// At rest: not reported as moving, and readings throughout the dwell spread by no more than twice
// the settle tolerance.
bool Carriage::comes_to_rest(double* position_mm) {
  const SteadyTime deadline =
      clock_->now() +
      duration_from_ms(latest_profile_.stopping_ms() + rules_.settle_ms + rules_.settle_timeout_ms);
  Dwell rest(duration_from_ms(rules_.settle_ms), 2.0 * rules_.settle_tolerance_mm);
  while (clock_->now() <= deadline) {
    const SliderState state = slider_->read_state();
    *position_mm = state.position_mm;
    rest.take(!state.moving.value_or(false), clock_->now(), state.position_mm);
    if (rest.is_over()) return true;
    pause();
  }
  return false;
}

}  // namespace raywalk::capture
