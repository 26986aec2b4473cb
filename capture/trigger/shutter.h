// The shutter of a still camera on opto-isolated lines: half-press, press, release, and wait until
// the camera is done.
//
//   focus   ___/-----------------\_______________________
//   shutter __________/----------\_______________________
//             focus_ms  pulse_ms
//   busy    ______________/-------------------\__________
//                     begins: the picture      ends: the camera can take the next
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "capture/base/clock.h"
#include "capture/camera/camera_config.h"
#include "capture/trigger/gpio_lines.h"

namespace raywalk::capture {

struct ShutterTimes {
  SteadyTime pressed{};  // the shutter line became active
  SteadyTime exposed{};  // the camera became busy; without a busy line, when it was pressed
  SteadyTime done{};     // the camera was no longer busy, or hold_ms had passed
};

// Both outputs are inactive except during a press, also after an exception. Calls throw
// DeviceFault, and Interrupted while they wait; a press itself is brief and not interrupted.
class Shutter {
 public:
  // Requests the lines. Throws UsageError without a shutter line, and as GpioChip does.
  Shutter(const TriggerConfig& config, std::unique_ptr<GpioChip> chip, Clock* clock);

  // "line 5 of /dev/gpiochip0 (pinctrl-bcm2711, 58 lines)"
  std::string description() const;
  // None without a busy line.
  std::optional<bool> is_busy();

  // Waits until the camera is free, presses, and waits until it is done. Throws DeviceFault kBusy
  // if it is busy for longer than busy_end_timeout_ms, before or after the press; kMissingPicture
  // if it does not become busy within busy_start_timeout_ms of the press, so it took no picture.
  ShutterTimes take_picture();

  // A press that starts a film and one that stops it, for cameras that toggle. The busy line, where
  // wired, must become active at the start (kMissingPicture) and inactive after the stop (kBusy).
  ShutterTimes start_film();
  ShutterTimes stop_film();

 private:
  ShutterTimes press_until_busy();
  SteadyTime press();
  void wait_until_done(ShutterTimes* times, const std::string& since);
  SteadyTime wait_for_busy(SteadyTime pressed);
  void wait_until_free(const std::string& since);
  void hold(double ms);
  void wait(double ms);
  Duration step_to(SteadyTime deadline) const;

  TriggerConfig config_;
  std::unique_ptr<GpioChip> chip_;  // before the lines, which it must outlive
  std::unique_ptr<GpioOutput> focus_;
  std::unique_ptr<GpioOutput> shutter_;
  std::unique_ptr<GpioInput> busy_;
  Clock* clock_;
};

}  // namespace raywalk::capture
