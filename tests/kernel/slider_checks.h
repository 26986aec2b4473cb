// The Modbus slider on emulated serial ports, against a pymodbus slave.
#pragma once

#include "tests/kernel/check_report.h"

namespace raywalk::capture {

// Needs the slave's line at /dev/ttyS1, serial_host.py's orders at /dev/ttyS2, and /dev/slider
// pointing to the USB adapter that was plugged in last.
void check_slider(CheckReport* report);

}  // namespace raywalk::capture
