// VideoDevice over the Video4Linux2 API (kernel.org, userspace-api/media/v4l), with buffers of the
// driver's mapped into memory.
#pragma once

#include <memory>
#include <string>

#include "capture/camera/video_device.h"

namespace raywalk::capture {

// `path` is a device node, best one of /dev/v4l/by-id, which stays the same when a camera is
// plugged in again. Throws DeviceFault: kNoContact where it is missing or not permitted,
// kWrongDevice where it is no camera that streams single-planar frames.
std::unique_ptr<VideoDevice> open_video_device(const std::string& path);

}  // namespace raywalk::capture
