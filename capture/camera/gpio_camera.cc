#include "capture/camera/gpio_camera.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/base/device_fault.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

// Longest delay of the reaction to an interrupt.
constexpr Duration kLongestStep = std::chrono::milliseconds(50);

std::string in_ms(double ms) { return std::to_string(std::lround(ms)) + " ms"; }

// Releases a line when an exception leaves a press.
class ReleaseOnExit {
 public:
  explicit ReleaseOnExit(GpioLine* line) : line_(line) {}
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
  GpioLine* line_;
};

}  // namespace

GpioCamera::GpioCamera(const TriggerConfig& config, std::unique_ptr<GpioChip> chip, Clock* clock)
    : config_(config), chip_(std::move(chip)), clock_(clock) {
  if (config.shutter_line < 0) {
    throw UsageError("trigger.shutter_line is not set; name the line that releases the shutter");
  }
  shutter_ = chip_->request({config.shutter_line, config.active_low, true});
  if (config.focus_line >= 0) {
    focus_ = chip_->request({config.focus_line, config.active_low, true});
  }
  if (config.busy_line >= 0) {
    busy_ = chip_->request({config.busy_line, config.busy_active_low, false});
  }
}

std::string GpioCamera::description() const {
  return "camera on line " + std::to_string(config_.shutter_line) + " of " + chip_->description();
}

CameraReport GpioCamera::report() {
  CameraReport report;
  report.identity = description();
  report.state = busy_ == nullptr ? "unknown" : busy_->is_active() ? "busy" : "idle";
  return report;
}

std::string GpioCamera::prepare(const ExposureSettings& exposure, const std::string& /*earlier*/) {
  if (exposure.shutter_s != 0.0 || exposure.iso != 0 || exposure.white_balance_k != 0) {
    throw UsageError(
        "the exposure of a gpio camera cannot be set; lock it on the camera and leave "
        "camera.exposure.shutter_s, iso and white_balance_k at 0");
  }
  presses_ = config_.press_per_exposure ? std::max<std::size_t>(exposure.bracket_ev.size(), 1) : 1;
  return "";
}

Shot GpioCamera::shoot(SteadyTime settled_at) {
  wait(ms_from_duration(settled_at - clock_->now()));
  Shot shot;
  Exposed first;
  for (std::size_t press = 0; press < presses_; ++press) {
    if (busy_ != nullptr) wait_until_free("before the shutter");
    const Exposed exposed = expose();
    if (press == 0) first = exposed;
    wait_until_done("after the shutter");
  }
  shot.triggered_at = wall_time_of(*clock_, first.pressed);
  shot.exposed_at = wall_time_of(*clock_, first.busy);
  shot.exposing_ms = ms_from_duration(clock_->now() - first.pressed);
  return shot;
}

void GpioCamera::start_video() { expose(); }

void GpioCamera::stop_video() {
  press();
  wait_until_done("after the video was stopped");
}

GpioCamera::Exposed GpioCamera::expose() {
  const SteadyTime pressed = press();
  return {pressed, busy_ == nullptr ? pressed : wait_for_busy(pressed)};
}

SteadyTime GpioCamera::press() {
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
  // Sleeps again after a signal.
  const SteadyTime end = clock_->now() + duration_from_ms(config_.pulse_ms);
  while (clock_->now() < end) clock_->sleep(end - clock_->now());
  // Here and not in ReleaseOnExit, because here a failure to release a line is an error.
  shutter_->set(false);
  if (focus_ != nullptr) focus_->set(false);
  return pressed;
}

SteadyTime GpioCamera::wait_for_busy(SteadyTime pressed) {
  const SteadyTime deadline = pressed + duration_from_ms(config_.busy_start_timeout_ms);
  for (;;) {
    // Any edge counts: of a pulse shorter than the kernel's latency only the end is reported.
    if (const auto edge = busy_->wait_edge(step_to(deadline))) return *edge;
    throw_if_interrupted();
    if (clock_->now() >= deadline) break;
  }
  throw DeviceFault(FaultKind::kMissingPicture,
                    "the camera did not become busy within " +
                        in_ms(config_.busy_start_timeout_ms) +
                        " of the shutter, so it took no picture; check that it is awake, that its "
                        "card has room, and the wiring of trigger.shutter_line and busy_line");
}

void GpioCamera::wait_until_free(const std::string& since) {
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

void GpioCamera::wait_until_done(const std::string& since) {
  if (busy_ == nullptr) {
    wait(config_.hold_ms);
  } else {
    wait_until_free(since);
  }
}

void GpioCamera::wait(double ms) {
  const SteadyTime end = clock_->now() + duration_from_ms(ms);
  while (clock_->now() < end) {
    throw_if_interrupted();
    clock_->sleep(step_to(end));
  }
}

Duration GpioCamera::step_to(SteadyTime deadline) const {
  return std::clamp(deadline - clock_->now(), Duration::zero(), kLongestStep);
}

}  // namespace raywalk::capture
