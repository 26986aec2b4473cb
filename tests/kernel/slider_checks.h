// Checks of the Modbus slider on emulated serial ports, against the simulated drive.
#pragma once

#include "tests/kernel/check_report.h"

namespace raywalk::capture {

// Needs the slave at /dev/ttyS1, the orders of serial_host.py at /dev/ttyS2, and /dev/slider linked
// to the USB adapter that was plugged in last.
void check_slider(CheckReport* report);

}  // namespace raywalk::capture
