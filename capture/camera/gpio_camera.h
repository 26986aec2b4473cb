// A still camera whose shutter is released by opto-isolated lines: half-press, press, release, and
// wait until it is done. Its pictures stay on its card and are imported later.
//
//   focus   ___/-----------------\_______________________
//   shutter __________/----------\_______________________
//             focus_ms  pulse_ms
//   busy    ______________/-------------------\__________
//                     begins: the picture      ends: the camera can take the next
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "capture/base/clock.h"
#include "capture/camera/camera.h"
#include "capture/camera/camera_config.h"
#include "capture/camera/gpio_lines.h"

namespace raywalk::capture {

// Exposure, white balance and bracketing are set on the camera itself, before the session.
//
// Both outputs are inactive except during a press, also after an exception. Calls throw
// DeviceFault, and Interrupted while they wait; a press itself is brief and not interrupted.
// Faults: kBusy if the camera is busy for longer than busy_end_timeout_ms, before or after a press;
// kMissingPicture if it does not become busy within busy_start_timeout_ms of a press.
class GpioCamera final : public Camera {
 public:
  // Requests the lines. Throws UsageError without a shutter line, and as GpioChip does.
  GpioCamera(const TriggerConfig& config, std::unique_ptr<GpioChip> chip, Clock* clock);

  // "camera on line 5 of /dev/gpiochip0 (pinctrl-bcm2711, 58 lines)"
  std::string description() const override;
  // State from the busy line: "idle", "busy", or "unknown" without one.
  CameraReport report() override;
  // Returns an empty text: nothing can be set or read back. Throws UsageError if shutter time, ISO
  // or white balance are given.
  std::string prepare(const ExposureSettings& exposure, const std::string& earlier) override;
  // A press for each exposure, or one for all (TriggerConfig::press_per_exposure), each once the
  // camera is free. exposed_at is when it became busy with the first exposure; without a busy line,
  // when the shutter was pressed.
  Shot shoot(SteadyTime settled_at) override;
  // One press each, for a camera that is set to record video. The busy line, where wired, must
  // become active at the start and inactive after the stop.
  void start_video() override;
  void stop_video() override;
  bool keeps_pictures() const override { return true; }

 private:
  struct Exposed {
    SteadyTime pressed{};
    SteadyTime busy{};  // without a busy line, when it was pressed
  };

  Exposed expose();
  SteadyTime press();
  SteadyTime wait_for_busy(SteadyTime pressed);
  void wait_until_free(const std::string& since);
  void wait_until_done(const std::string& since);
  void wait(double ms);
  Duration step_to(SteadyTime deadline) const;

  TriggerConfig config_;
  std::unique_ptr<GpioChip> chip_;  // before the lines, which it must outlive
  std::unique_ptr<GpioLine> shutter_;
  std::unique_ptr<GpioLine> focus_;  // none if it is not wired, as the next one
  std::unique_ptr<GpioLine> busy_;
  Clock* clock_;
  std::size_t presses_ = 1;  // at each station
};

}  // namespace raywalk::capture
