// VideoDevice over the Video4Linux2 API (kernel.org, userspace-api/media/v4l), with the driver's
// buffers mapped into memory.
#pragma once

#include <memory>
#include <string>

#include "capture/camera/video_device.h"

namespace raywalk::capture {

// `path` is a device node, preferably in /dev/v4l/by-id, whose names survive replugging. Throws
// DeviceFault: kNoContact if it is missing or not permitted, kWrongDevice if it is not a camera
// that streams single-planar frames.
std::unique_ptr<VideoDevice> open_video_device(const std::string& path);

}  // namespace raywalk::capture
