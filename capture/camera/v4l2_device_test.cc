// Errors of open_video_device without a camera. tests/kernel runs it on real kernel drivers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/base/test_fault.h"
#include "capture/camera/video_device.h"

namespace raywalk::capture {
namespace {

TEST(V4l2Device, MissingDeviceIsNoContact) {
  expect_fault(FaultKind::kNoContact,
               "no camera at /dev/v4l/by-id/missing; plug it in, or set camera.v4l2.device",
               [] { open_video_device("/dev/v4l/by-id/missing"); });
}

TEST(V4l2Device, AnotherDeviceIsNoCamera) {
  expect_fault(FaultKind::kWrongDevice, "/dev/null is not a camera that streams",
               [] { open_video_device("/dev/null"); });
}

TEST(V4l2Device, DirectoryCannotBeOpened) {
  expect_fault(FaultKind::kNoContact, "cannot open camera /dev (Is a directory)",
               [] { open_video_device("/dev"); });
}

}  // namespace
}  // namespace raywalk::capture
