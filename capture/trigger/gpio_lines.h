// Interface to GPIO lines: a chip whose lines are requested as outputs that are set or inputs that
// report edges. Implemented by libgpiod 1.6 or 2.x (gpiod_lines_v1.cc or gpiod_lines_v2.cc; the
// build chooses by the installed version), and by a fake chip (fake_gpio.h).
//
// "Active" is the logical level: high, or low for a line declared active low.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "capture/base/clock.h"
#include "capture/base/device_fault.h"

namespace raywalk::capture {

struct GpioLine {
  int offset = 0;  // on its chip, from 0
  bool active_low = false;
};

struct GpioEdge {
  bool active = false;  // the level after the edge
  // CLOCK_MONOTONIC, as the kernel stamps GPIO events since Linux 5.7.
  SteadyTime time{};
};

// A line owned exclusively until destroyed.
class GpioOutput {
 public:
  GpioOutput() = default;
  GpioOutput(const GpioOutput&) = delete;
  GpioOutput& operator=(const GpioOutput&) = delete;
  // Leaves the line inactive. The state of a pin without an owner depends on its driver (many
  // become inputs), so the wiring must hold an open line inactive.
  virtual ~GpioOutput() = default;

  // Throws DeviceFault kNoContact if the chip was removed.
  virtual void set(bool active) = 0;
};

// The kernel queues edges (up to 16) from the request on, so none between two waits is lost.
class GpioInput {
 public:
  GpioInput() = default;
  GpioInput(const GpioInput&) = delete;
  GpioInput& operator=(const GpioInput&) = delete;
  virtual ~GpioInput() = default;

  virtual bool is_active() = 0;
  // The oldest queued edge; none after `timeout`, or earlier if a signal arrives. A timeout of zero
  // does not wait.
  virtual std::optional<GpioEdge> wait_edge(Duration timeout) = 0;
};

// Requests throw DeviceFault naming chip and line: kWrongDevice if the chip has no such line,
// kNoContact if another program owns it or permission is missing. The chip must outlive its lines.
class GpioChip {
 public:
  GpioChip() = default;
  GpioChip(const GpioChip&) = delete;
  GpioChip& operator=(const GpioChip&) = delete;
  virtual ~GpioChip() = default;

  // "/dev/gpiochip0 (pinctrl-bcm2711, 58 lines)"
  virtual std::string description() const = 0;
  // Inactive from the first moment, without a glitch.
  virtual std::unique_ptr<GpioOutput> request_output(const GpioLine& line) = 0;
  virtual std::unique_ptr<GpioInput> request_input(const GpioLine& line) = 0;
};

// `chip` is a device ("/dev/gpiochip0") or its name in /dev ("gpiochip0"). Throws DeviceFault:
// kNoContact if it is missing or not permitted, kWrongDevice if it is not a GPIO chip.
std::unique_ptr<GpioChip> open_gpio_chip(const std::string& chip);

// --- Errors, for the implementations -------------------------------------------------------------

// The path of a chip: unchanged if it contains a '/', else in /dev.
std::string gpio_chip_path(const std::string& chip);

// For a chip that cannot be opened. `error` is the errno of the failed call.
DeviceFault gpio_open_fault(const std::string& path, int error);

struct GpioRequestFailure {
  std::string path;  // of the chip
  int offset = 0;    // of the line
  int line_count = 0;
  int error = 0;         // errno of the failed call
  std::string consumer;  // the owner of the line; empty if unknown
};
// For a line that cannot be requested.
DeviceFault gpio_request_fault(const GpioRequestFailure& failure);

// For a failed read, write or wait on a requested line.
DeviceFault gpio_line_fault(const std::string& path, int offset, int error);

}  // namespace raywalk::capture
