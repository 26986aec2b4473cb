// Checks that run in order and print one line each. GoogleTest is not used, as the drivers keep
// state between checks and the console of the virtual machine should stay readable.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

#include "capture/base/device_fault.h"

namespace raywalk::capture {

class CheckFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class CheckReport {
 public:
  // Prints "ok NAME", or "FAIL NAME: why" if `check` throws; continues in either case.
  void run(const std::string& name, const std::function<void()>& check);

  int passed() const { return passed_; }
  int failed() const { return failed_; }

 private:
  int passed_ = 0;
  int failed_ = 0;
};

// Throw CheckFailure if the condition is not met.
void require(bool holds, const std::string& what);
void require_near(double value, double expected, double tolerance, const std::string& what);

// Throws CheckFailure unless `call` throws a DeviceFault of this kind with a one-line message that
// contains `words` and, after a semicolon, a remedy.
void require_fault(FaultKind kind, const std::string& words, const std::function<void()>& call);

// The shutter on GPIO lines of the kernel's gpio-sim. Needs a gpio-sim device "camera" in configfs
// with one bank, "bank0", of 8 lines; removes it.
void check_gpio(CheckReport* report);

// The Modbus slider on emulated serial ports, against the simulated drive. Needs the slave at
// /dev/ttyS1, the orders of serial_host.py at /dev/ttyS2, and /dev/slider linked to the USB adapter
// that was plugged in last.
void check_slider(CheckReport* report);

// The V4L2 camera on the kernel's vivid driver. Needs vivid at /dev/video0 with a webcam as input 0
// and HDMI as input 1.
//
// vivid does not support MJPG, which is covered by unit tests only: v4l2loopback supports it, but
// is not part of the kernel and must be built with dkms.
void check_video(CheckReport* report);

}  // namespace raywalk::capture
