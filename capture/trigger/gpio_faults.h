// Error messages shared by the implementations of gpio_lines.h.
#pragma once

#include <string>

#include "capture/base/device_fault.h"

namespace raywalk::capture {

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
