// Errors of open_gpio_chip without a chip. tests/kernel runs it on real kernel drivers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/base/test_fault.h"
#include "capture/trigger/gpio_lines.h"

namespace raywalk::capture {
namespace {

TEST(GpiodLines, MissingChipIsNoContact) {
  const DeviceFault fault = fault_of([] { open_gpio_chip("gpiochip-missing"); });
  EXPECT_EQ(fault.kind(), FaultKind::kNoContact);
  EXPECT_STREQ(fault.what(),
               "no GPIO chip /dev/gpiochip-missing; set trigger.chip to one that gpiodetect lists");
}

TEST(GpiodLines, AnotherDeviceIsNoChip) {
  expect_fault(FaultKind::kWrongDevice, "/dev/null is not a GPIO chip",
               [] { open_gpio_chip("/dev/null"); });
}

}  // namespace
}  // namespace raywalk::capture
