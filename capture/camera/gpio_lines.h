// GPIO lines: a chip whose lines are requested as outputs that are set or as inputs that report
// edges, by libgpiod 1.6 or 2.x (gpiod_lines_v1.cc or gpiod_lines_v2.cc; the build chooses by the
// installed version).
//
// "Active" is the logical level: high, or low for a line declared active low.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "capture/base/clock.h"
#include "capture/base/device_fault.h"

namespace raywalk::capture {

struct GpioRequest {
  int offset = 0;  // of the line on its chip, from 0
  bool active_low = false;
  bool is_output = false;
};

// A line owned exclusively until destroyed. The state of a pin without an owner depends on its
// driver (many become inputs), so the wiring must hold an open line inactive. Calls throw
// DeviceFault kNoContact if the chip was removed.
class GpioLine {
 public:
  GpioLine() = default;
  GpioLine(const GpioLine&) = delete;
  GpioLine& operator=(const GpioLine&) = delete;
  virtual ~GpioLine() = default;

  // Of an output.
  virtual void set(bool active) = 0;
  // Of an input, as the next one.
  virtual bool is_active() = 0;
  // The time of the oldest queued edge (CLOCK_MONOTONIC, as the kernel stamps GPIO events since
  // Linux 5.7); none after `timeout`, or earlier if a signal arrives. A timeout of zero does not
  // wait. The kernel queues edges (up to 16) from the request on, so none between two waits is
  // lost.
  virtual std::optional<SteadyTime> wait_edge(Duration timeout) = 0;
};

class GpioChip {
 public:
  GpioChip() = default;
  GpioChip(const GpioChip&) = delete;
  GpioChip& operator=(const GpioChip&) = delete;
  virtual ~GpioChip() = default;

  // "/dev/gpiochip0 (pinctrl-bcm2711, 58 lines)"
  virtual std::string description() const = 0;
  // An output is inactive from the first moment, without a glitch. The chip must outlive the line.
  // Throws DeviceFault naming chip and line: kWrongDevice if the chip has no such line, kNoContact
  // if another program owns it or permission is missing.
  virtual std::unique_ptr<GpioLine> request(const GpioRequest& line) = 0;
};

// `chip` is a device ("/dev/gpiochip0") or its name in /dev ("gpiochip0"). Throws DeviceFault:
// kNoContact if it is missing or not permitted, kWrongDevice if it is not a GPIO chip.
std::unique_ptr<GpioChip> open_gpio_chip(const std::string& chip);

// --- For the implementations ---------------------------------------------------------------------

inline constexpr const char* kGpioConsumer = "raywalk-capture";

// The path of a chip: unchanged if it contains a '/', else in /dev.
std::string gpio_chip_path(const std::string& chip);

// For a chip that cannot be opened. `error` is the errno of the failed call, as below.
DeviceFault gpio_open_fault(const std::string& path, int error);

struct GpioRequestFailure {
  std::string path;  // of the chip
  int offset = 0;    // of the line
  int line_count = 0;
  int error = 0;
  std::string consumer{};  // the owner of the line; empty if unknown
};
DeviceFault gpio_request_fault(const GpioRequestFailure& failure);

// For a failed read, write or wait on a requested line.
DeviceFault gpio_line_fault(const std::string& path, int offset, int error);

}  // namespace raywalk::capture
