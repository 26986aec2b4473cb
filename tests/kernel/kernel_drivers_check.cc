// Checks of the device code against the kernel's drivers. Runs as root in the virtual machine of
// scripts/test-kernel-drivers, after guest_init has loaded and set up the drivers.
#include <cstdio>

#include "tests/kernel/check_report.h"

int main() {
  raywalk::capture::CheckReport report;
  raywalk::capture::check_gpio(&report);
  raywalk::capture::check_video(&report);
  raywalk::capture::check_slider(&report);
  // The script requires this line as evidence that the run completed.
  std::printf("kernel drivers: %d checks passed, %d failed\n", report.passed(), report.failed());
  return report.failed() == 0 ? 0 : 1;
}
