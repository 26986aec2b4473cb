#include "capture/camera/gpio_camera.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {

GpioCamera::GpioCamera(const TriggerConfig& config, std::unique_ptr<GpioChip> chip, Clock* clock)
    : press_per_exposure_(config.press_per_exposure),
      shutter_(config, std::move(chip), clock),
      clock_(clock) {}

std::string GpioCamera::description() const { return "camera on " + shutter_.description(); }

CameraReport GpioCamera::report() {
  CameraReport report;
  report.identity = description();
  const std::optional<bool> busy = shutter_.is_busy();
  report.state = !busy ? "unknown" : *busy ? "busy" : "idle";
  return report;
}

std::string GpioCamera::prepare(const ExposureSettings& exposure, const std::string& /*earlier*/) {
  if (exposure.shutter_s != 0.0 || exposure.iso != 0 || exposure.white_balance_k != 0) {
    throw UsageError(
        "the exposure of a gpio camera cannot be set; lock it on the camera and leave "
        "camera.exposure.shutter_s, iso and white_balance_k at 0");
  }
  presses_ = press_per_exposure_ ? std::max<std::size_t>(exposure.bracket_ev.size(), 1) : 1;
  return "";
}

Shot GpioCamera::shoot(SteadyTime settled_at) {
  while (clock_->now() < settled_at) {
    throw_if_interrupted();
    clock_->sleep(settled_at - clock_->now());
  }
  const ShutterTimes first = shutter_.take_picture();
  ShutterTimes last = first;
  for (std::size_t press = 1; press < presses_; ++press) last = shutter_.take_picture();
  Shot shot;
  shot.triggered_at = wall_time_of(*clock_, first.pressed);
  shot.exposed_at = wall_time_of(*clock_, first.exposed);
  shot.exposing_ms = ms_from_duration(last.done - first.pressed);
  return shot;
}

void GpioCamera::start_film() { shutter_.start_film(); }

void GpioCamera::stop_film() { shutter_.stop_film(); }

}  // namespace raywalk::capture
