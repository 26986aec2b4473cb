// A camera triggered by a shutter line. Its pictures stay on its card and are imported later.
#pragma once

#include <memory>
#include <string>

#include "capture/camera/camera.h"
#include "capture/camera/camera_config.h"
#include "capture/trigger/gpio_lines.h"
#include "capture/trigger/shutter.h"

namespace raywalk::capture {

// Exposure, white balance and bracketing are set on the camera itself, before the session. A camera
// that brackets takes one exposure at each press, or all at one press
// (TriggerConfig::press_per_exposure).
class GpioCamera final : public Camera {
 public:
  // Throws as Shutter's constructor does.
  GpioCamera(const TriggerConfig& config, std::unique_ptr<GpioChip> chip, Clock* clock);

  std::string description() const override;
  // State from the busy line: "idle", "busy", or "unknown" without one.
  CameraReport report() override;
  // Returns an empty text: nothing can be set or read back. Throws UsageError if shutter time, ISO
  // or white balance are given.
  std::string prepare(const ExposureSettings& exposure, const std::string& earlier) override;
  // exposed_at is when the camera became busy with the first exposure; without a busy line, when
  // the shutter was pressed.
  Shot shoot(SteadyTime settled_at) override;
  // One press each, for a camera that is set to film.
  void start_film() override;
  void stop_film() override;
  bool keeps_pictures() const override { return true; }

 private:
  bool press_per_exposure_;
  std::size_t presses_ = 1;  // at each station
  Shutter shutter_;
  Clock* clock_;
};

}  // namespace raywalk::capture
