// Moves of the carriage, each supervised until it has settled or has been stopped.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "capture/base/clock.h"
#include "capture/slider/slider_state.h"
#include "capture/slider/soft_limits.h"

namespace raywalk::capture {

class ModbusSlider;

// When a move counts as settled and when as failed. All positive; settle_ms may be 0.
struct MotionRules {
  MotionProfile profile{};
  double settle_tolerance_mm = 0.1;   // feedback within this of the target ...
  double settle_ms = 300.0;           // ... for this long
  double settle_timeout_ms = 5000.0;  // after the move should have ended
  double following_error_mm = 5.0;    // allowed outside the path from start to target
  // Without progress by settle_tolerance_mm, on top of the time that such a step takes.
  double stall_ms = 1000.0;
  double poll_ms = 10.0;
  double homing_timeout_ms = 120000.0;
};

struct SettledPosition {
  double commanded_mm = 0.0;
  double measured_mm = 0.0;  // mean of the feedback over the dwell
  double moving_ms = 0.0;    // from the command until the feedback was first within the tolerance
  double settling_ms = 0.0;  // from then to the end of the dwell
  SteadyTime settled_at{};
};

// The only object that moves the slider. On a fault, every call but stop() first stops the slider
// and then throws DeviceFault: alarm (also a motor that is not enabled, or a drive that is not
// homed), limit switch, stall, following error, timeout, loss of contact. The message says whether
// the stop was confirmed. When the user interrupts, the calls decelerate to a stop and throw
// Interrupted, or DeviceFault if that stop cannot be confirmed. Exceptions of the `watch` callback
// are rethrown after the stop. The destructor stops an unfinished motion.
//
// No decision rests on a single reading: a position off the path must be read twice in a row, and
// settling takes at least three readings at the target.
class Carriage {
 public:
  // Called with every reading of the feedback, for the journal.
  using Watch = std::function<void(WallTime time, double position_mm)>;

  // Slider and clock must outlive it.
  Carriage(ModbusSlider* slider, Clock* clock, const SoftLimits& limits, const MotionRules& rules);
  ~Carriage();
  Carriage(const Carriage&) = delete;
  Carriage& operator=(const Carriage&) = delete;

  const SoftLimits& limits() const { return limits_; }
  void watch(Watch watch) { watch_ = std::move(watch); }

  // Moves to the home switch and sets 0 mm there; positions and soft limits refer to it.
  void home();
  // Stops any motion in progress first. Returns when the carriage has settled at the target.
  SettledPosition move_to(SafePosition target);
  // The same with another motion profile, for slow passes.
  SettledPosition move_to(SafePosition target, const MotionProfile& profile);
  // Decelerates and waits for standstill. Throws DeviceFault where standstill is not confirmed.
  void stop();

 private:
  struct StopOutcome;

  template <typename Motion>
  auto supervise(const Motion& motion);
  SliderState read();
  SliderState ready_to_move();
  SliderState read_start();
  StopOutcome bring_to_rest();
  bool comes_to_rest(double* position_mm);
  void pause() { clock_->sleep(duration_from_ms(rules_.poll_ms)); }

  ModbusSlider* slider_;
  Clock* clock_;
  SoftLimits limits_;
  MotionRules rules_;
  Watch watch_;
  bool may_be_moving_ = false;
  MotionProfile latest_profile_{};
};

}  // namespace raywalk::capture
