// The far side of gpio-sim's lines, and a camera that hangs on them.
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
  // The device "camera" of configfs. Throws CheckFailure where it is not there.
  GpioSim();

  // Its name in /dev.
  const std::string& chip() const { return chip_; }
  bool level(int line) const;
  void pull(int line, bool up) const;
  // Takes the chip away, whoever uses it.
  void unplug() const;

 private:
  std::string chip_;
  std::string lines_;  // the directory of the lines in sysfs
};

// What a camera saw of one press; a time that never came is SteadyTime{}.
struct SeenPress {
  SteadyTime focused{};
  SteadyTime pressed{};
  SteadyTime released{};
  SteadyTime let_go{};      // of the half-press
  SteadyTime busy_from{};   // just before its busy line rose
  SteadyTime busy_until{};  // just before it fell
};

// Watches the focus and shutter lines and answers on the busy line, in a thread of its own.
class WiredCamera {
 public:
  WiredCamera(const GpioSim& lines, bool active_low);
  // The busy line is low afterwards.
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
  std::jthread thread_;  // the last member: it uses the others
};

}  // namespace raywalk::capture
