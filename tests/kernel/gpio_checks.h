// Checks of the shutter on GPIO lines of the kernel's gpio-sim.
#pragma once

#include "tests/kernel/check_report.h"

namespace raywalk::capture {

// Needs a gpio-sim device "camera" in configfs with one bank, "bank0", of 8 lines; removes it.
void check_gpio(CheckReport* report);

}  // namespace raywalk::capture
