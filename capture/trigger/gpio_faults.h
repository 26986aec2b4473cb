// What went wrong with a GPIO chip, in words that every implementation of gpio_lines.h shares.
#pragma once

#include <string>

#include "capture/base/device_fault.h"

namespace raywalk::capture {

// The device behind the name a user gives: as it is where it holds a '/', else in /dev.
std::string gpio_chip_path(const std::string& chip);

// `error` is the errno of the call that failed.
DeviceFault gpio_open_fault(const std::string& path, int error);

struct GpioRequestFailure {
  std::string path;  // of the chip
  int offset = 0;    // of the line
  int line_count = 0;
  int error = 0;         // errno of the call that failed
  std::string consumer;  // who holds the line; empty where unknown
};
DeviceFault gpio_request_fault(const GpioRequestFailure& failure);

// Reading, setting or waiting on a line that was requested.
DeviceFault gpio_line_fault(const std::string& path, int offset, int error);

}  // namespace raywalk::capture
