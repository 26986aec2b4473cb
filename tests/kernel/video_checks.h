// Checks of the V4L2 camera on the kernel's vivid driver.
#pragma once

#include "tests/kernel/check_report.h"

namespace raywalk::capture {

// Needs vivid at /dev/video0 with a webcam as input 0 and HDMI as input 1.
//
// vivid does not support MJPG, which is covered by unit tests only: v4l2loopback supports it, but
// is not part of the kernel and must be built with dkms.
void check_video(CheckReport* report);

}  // namespace raywalk::capture
