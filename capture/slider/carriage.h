// Moves of the carriage that are seen through to their end, or stopped.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "capture/base/clock.h"
#include "capture/slider/slider.h"

namespace raywalk::capture {

// When a move counts as done, and what is taken as gone wrong. All positive, settle_ms may be 0.
struct MotionRules {
  MotionProfile profile{};
  double settle_tolerance_mm = 0.1;   // feedback within this of the target ...
  double settle_ms = 300.0;           // ... all through this time
  double settle_timeout_ms = 5000.0;  // after the move should have ended
  double following_error_mm = 5.0;    // off the way from start to target, or beyond either
  double stall_ms = 1000.0;  // without progress by the tolerance, beyond the time that takes
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

// Owns the right to move. Every call but stop() throws DeviceFault after it has stopped the slider:
// alarm (also a motor that is not enabled, or a drive that has lost its home), limit switch, stall,
// following error, timeout, loss of contact; the message says whether the stop was confirmed. It
// throws Interrupted, after the decelerated stop, when the user asks to stop, and DeviceFault
// instead where that stop cannot be confirmed. Whatever `watch` throws passes through, after the
// stop. The destructor stops a motion that was not seen to its end.
//
// A single reading is never believed where it would decide something alone: a position off the way
// has to be read twice in a row, and settling takes at least three good readings.
class Carriage {
 public:
  // `watch`, if given, is called with every reading of the feedback, for the journal.
  using Watch = std::function<void(WallTime time, double position_mm)>;

  // Slider and clock have to outlive it.
  Carriage(Slider* slider, Clock* clock, const SoftLimits& limits, const MotionRules& rules);
  ~Carriage();
  Carriage(const Carriage&) = delete;
  Carriage& operator=(const Carriage&) = delete;

  const SoftLimits& limits() const { return limits_; }
  void watch(Watch watch) { watch_ = std::move(watch); }

  // Looks for the home switch, which becomes 0 mm; the soft limits count from then on.
  void home();
  // Stops a motion that is under way first. Returns when the carriage has settled at the target.
  SettledPosition move_to(SafePosition target);
  // The same at another speed, for slow passes.
  SettledPosition move_to(SafePosition target, const MotionProfile& profile);
  // Decelerates and waits for standstill. Throws DeviceFault where standstill is not confirmed.
  void stop();

 private:
  struct StopOutcome;

  template <typename Motion>
  auto see_through(const Motion& motion);
  SliderState read();
  SliderState ready_to_move();
  SliderState read_start();
  StopOutcome bring_to_rest();
  bool comes_to_rest(double* position_mm);
  void pause() { clock_->sleep(duration_from_ms(rules_.poll_ms)); }

  Slider* slider_;
  Clock* clock_;
  SoftLimits limits_;
  MotionRules rules_;
  Watch watch_;
  bool may_be_moving_ = false;
  MotionProfile latest_profile_{};
};

}  // namespace raywalk::capture
