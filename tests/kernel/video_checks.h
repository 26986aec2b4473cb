// The V4L2 camera on the kernel's vivid driver.
#pragma once

#include "tests/kernel/check_report.h"

namespace raywalk::capture {

// Needs vivid at /dev/video0 with a webcam as input 0 and HDMI as input 1.
//
// vivid has no MJPG; that format is left to the unit tests, as v4l2loopback, which has it, is no
// part of the kernel and has to be built with dkms.
void check_video(CheckReport* report);

}  // namespace raywalk::capture
