// The simulated side of gpio-sim's lines, and a simulated camera connected to them.
#pragma once

#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "capture/base/clock.h"

namespace raywalk::capture {

constexpr int kFocusLine = 0;
constexpr int kShutterLine = 1;
constexpr int kBusyLine = 2;

// Levels are those of the wire: true is high. (Documentation/admin-guide/gpio/gpio-sim.rst)
class GpioSim {
 public:
  // The device "camera" of configfs. Throws CheckFailure if it does not exist.
  GpioSim();

  // Its name in /dev.
  const std::string& chip() const { return chip_; }
  bool level(int line) const;
  void pull(int line, bool up) const;
  // Removes the chip even while it is in use.
  void unplug() const;

 private:
  std::string chip_;
  std::string lines_;  // sysfs directory of the lines
};

// Times of one press as seen by the camera; SteadyTime{} if it did not occur.
struct SeenPress {
  SteadyTime focused{};
  SteadyTime pressed{};
  SteadyTime released{};
  SteadyTime unfocused{};   // end of the half-press
  SteadyTime busy_from{};   // just before the busy line rose
  SteadyTime busy_until{};  // just before it fell
};

// Monitors the focus and shutter lines and drives the busy line, in its own thread.
class WiredCamera {
 public:
  WiredCamera(const GpioSim& lines, bool active_low);
  // Leaves the busy line low.
  ~WiredCamera();
  WiredCamera(const WiredCamera&) = delete;
  WiredCamera& operator=(const WiredCamera&) = delete;

  std::vector<SeenPress> presses();

 private:
  void work(const std::stop_token& stop);
  void look();
  void answer();

  const GpioSim& lines_;
  bool active_low_;
  bool focused_ = false;
  bool pressed_ = false;
  std::mutex mutex_;
  std::vector<SeenPress> presses_;
  std::jthread thread_;  // last, as it uses the other members
};

}  // namespace raywalk::capture
