#include "capture/trigger/shutter.h"

#include <algorithm>
#include <cmath>

#include "capture/base/device_fault.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

// Longest delay of the reaction to an interrupt.
constexpr Duration kStep = std::chrono::milliseconds(50);

std::string in_ms(double ms) { return std::to_string(std::lround(ms)) + " ms"; }

// Releases a line when an exception leaves a press.
class ReleaseOnExit {
 public:
  explicit ReleaseOnExit(GpioOutput* line) : line_(line) {}
  ~ReleaseOnExit() {
    try {
      if (line_ != nullptr) line_->set(false);
    } catch (const DeviceFault&) {
      // The chip was removed; the failed press reports it.
    }
  }
  ReleaseOnExit(const ReleaseOnExit&) = delete;
  ReleaseOnExit& operator=(const ReleaseOnExit&) = delete;

 private:
  GpioOutput* line_;
};

}  // namespace

Shutter::Shutter(const TriggerConfig& config, std::unique_ptr<GpioChip> chip, Clock* clock)
    : config_(config), chip_(std::move(chip)), clock_(clock) {
  if (config.shutter_line < 0) {
    throw UsageError("trigger.shutter_line is not set; name the line that releases the shutter");
  }
  shutter_ = chip_->request_output({config.shutter_line, config.active_low});
  if (config.focus_line >= 0) {
    focus_ = chip_->request_output({config.focus_line, config.active_low});
  }
  if (config.busy_line >= 0) {
    busy_ = chip_->request_input({config.busy_line, config.busy_active_low});
  }
}

std::string Shutter::description() const {
  return "line " + std::to_string(config_.shutter_line) + " of " + chip_->description();
}

std::optional<bool> Shutter::is_busy() {
  if (busy_ == nullptr) return std::nullopt;
  return busy_->is_active();
}

ShutterTimes Shutter::take_picture() {
  if (busy_ != nullptr) wait_until_free("before the shutter");
  ShutterTimes times = press_until_busy();
  wait_until_done(&times, "after the shutter");
  return times;
}

ShutterTimes Shutter::start_film() { return press_until_busy(); }

ShutterTimes Shutter::stop_film() {
  ShutterTimes times;
  times.pressed = press();
  times.exposed = times.pressed;
  wait_until_done(&times, "after the film was stopped");
  return times;
}

ShutterTimes Shutter::press_until_busy() {
  ShutterTimes times;
  times.pressed = press();
  times.exposed = busy_ == nullptr ? times.pressed : wait_for_busy(times.pressed);
  times.done = clock_->now();
  return times;
}

void Shutter::wait_until_done(ShutterTimes* times, const std::string& since) {
  if (busy_ == nullptr) {
    wait(config_.hold_ms);
  } else {
    wait_until_free(since);
  }
  times->done = clock_->now();
}

SteadyTime Shutter::press() {
  const ReleaseOnExit focus(focus_.get());
  const ReleaseOnExit shutter(shutter_.get());
  if (focus_ != nullptr) {
    focus_->set(true);
    wait(config_.focus_ms);
  }
  throw_if_interrupted();
  // Drops earlier edges of the busy line, also of the half-press: they do not belong to this
  // picture.
  while (busy_ != nullptr && busy_->wait_edge(Duration::zero())) {
  }
  const SteadyTime pressed = clock_->now();
  shutter_->set(true);
  hold(config_.pulse_ms);
  // Here and not in ReleaseOnExit, because here a failure to release a line is an error.
  shutter_->set(false);
  if (focus_ != nullptr) focus_->set(false);
  return pressed;
}

// Sleeps again after a signal.
void Shutter::hold(double ms) {
  const SteadyTime end = clock_->now() + duration_from_ms(ms);
  while (clock_->now() < end) clock_->sleep(end - clock_->now());
}

void Shutter::wait(double ms) {
  const SteadyTime end = clock_->now() + duration_from_ms(ms);
  while (clock_->now() < end) {
    throw_if_interrupted();
    clock_->sleep(step_to(end));
  }
}

SteadyTime Shutter::wait_for_busy(SteadyTime pressed) {
  const SteadyTime deadline = pressed + duration_from_ms(config_.busy_start_timeout_ms);
  for (;;) {
    // Any edge counts: of a pulse shorter than the kernel's latency only the end is reported.
    if (const auto edge = busy_->wait_edge(step_to(deadline))) return edge->time;
    throw_if_interrupted();
    if (clock_->now() >= deadline) break;
  }
  throw DeviceFault(FaultKind::kMissingPicture,
                    "the camera did not become busy within " +
                        in_ms(config_.busy_start_timeout_ms) +
                        " of the shutter, so it took no picture; check that it is awake, that its "
                        "card has room, and the wiring of trigger.shutter_line and busy_line");
}

void Shutter::wait_until_free(const std::string& since) {
  const SteadyTime deadline = clock_->now() + duration_from_ms(config_.busy_end_timeout_ms);
  while (busy_->is_active()) {
    throw_if_interrupted();
    if (clock_->now() >= deadline) {
      throw DeviceFault(FaultKind::kBusy, "the camera stayed busy for " +
                                              in_ms(config_.busy_end_timeout_ms) + " " + since +
                                              "; check its display, switch it off and on if "
                                              "needed, and check trigger.busy_active_low");
    }
    // Wakes early at an edge; the level decides.
    busy_->wait_edge(step_to(deadline));
  }
}

Duration Shutter::step_to(SteadyTime deadline) const {
  return std::clamp(deadline - clock_->now(), Duration::zero(), kStep);
}

}  // namespace raywalk::capture
