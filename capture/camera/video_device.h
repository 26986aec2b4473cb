// Interface to a video capture device, implemented over Video4Linux2 (v4l2_device.cc) and by a fake
// (fake_video_device.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "capture/base/clock.h"
#include "capture/base/word_of.h"
#include "core/geometry/sphere.h"

namespace raywalk::capture {

struct VideoIdentity {
  std::string driver;  // "uvcvideo 6.1.55"
  std::string card;    // model name
  std::string bus;     // USB or PCI address
};

// The encoding of Y'CbCr samples: luma coefficients kr, kb of the red and blue primaries, and
// range.
struct VideoColour {
  double kr = 0.299;  // ITU-R BT.601
  double kb = 0.114;
  bool full_range = false;  // Y' 0..255; else 16..235, and chroma 16..240 around 128
};

struct VideoFormat {
  std::string pixels;  // four characters, as V4L2 names it: "MJPG", "YUYV", ...
  PanoramaSize size{};
  std::size_t bytes_per_line = 0;  // of YUYV; at least 2 * width
  VideoColour colour{};            // of YUYV
};

// A frame from the driver. `bytes` are valid until the next call of next_frame.
struct VideoFrame {
  std::span<const std::byte> bytes;
  // The driver's timestamp; none if it is not of CLOCK_MONOTONIC. Drivers differ in what it marks:
  // uvcvideo the arrival of the frame's first packet, others that of its last.
  std::optional<SteadyTime> stamped_at;
  bool is_damaged = false;  // flagged by the driver
};

// Settings of a camera that this program locks, in V4L2's units.
enum class VideoControl {
  kExposureMode,      // V4L2_CID_EXPOSURE_AUTO: a value of V4L2_EXPOSURE_...
  kExposure,          // V4L2_CID_EXPOSURE_ABSOLUTE, 0.1 ms
  kAutoGain,          // V4L2_CID_AUTOGAIN: 0 or 1
  kGain,              // V4L2_CID_GAIN, no unit
  kAutoWhiteBalance,  // V4L2_CID_AUTO_WHITE_BALANCE: 0 or 1
  kWhiteBalance,      // V4L2_CID_WHITE_BALANCE_TEMPERATURE, kelvin
};

// The name in messages and in the JSON of a session: "exposure_100us", "gain", ...
inline std::string name_of(VideoControl control) {
  return std::string(word_of(control, {"exposure_mode", "exposure_100us", "auto_gain", "gain",
                                       "auto_white_balance", "white_balance_k"}));
}

struct ControlRange {
  int least = 0;
  int most = 0;
  int step = 1;
};

// Calls throw DeviceFault: kNoContact if the device was unplugged or fails, kBusy if another
// program streams from it.
class VideoDevice {
 public:
  VideoDevice() = default;
  VideoDevice(const VideoDevice&) = delete;
  VideoDevice& operator=(const VideoDevice&) = delete;
  virtual ~VideoDevice() = default;

  // The configured path, for messages.
  virtual std::string path() const = 0;
  virtual VideoIdentity identity() const = 0;

  // The frame size of the current format.
  virtual PanoramaSize current_size() = 0;
  // The format nearest to `pixels` and `size` that the driver supports, which may differ in both.
  // try_format changes nothing; set_format is allowed before start() only.
  virtual VideoFormat try_format(const std::string& pixels, PanoramaSize size) = 0;
  virtual VideoFormat set_format(const std::string& pixels, PanoramaSize size) = 0;

  // None if the camera has no such control or it is inactive.
  virtual std::optional<ControlRange> range_of(VideoControl control) = 0;
  virtual int control(VideoControl control) = 0;
  // False if the driver refuses the value. Drivers may round it: read it back.
  virtual bool set_control(VideoControl control, int value) = 0;

  // Starts streaming, once, into at least `buffers` buffers.
  virtual void start(int buffers) = 0;
  // The oldest queued frame, which may have been exposed long ago. None after `timeout`, or earlier
  // if a signal arrives.
  virtual std::optional<VideoFrame> next_frame(Duration timeout) = 0;
};

// By memory-mapped streaming over the Video4Linux2 API (kernel.org, userspace-api/media/v4l).
// `path` is a device node, preferably in /dev/v4l/by-id, whose names survive replugging. Throws
// DeviceFault: kNoContact if it is missing or not permitted, kWrongDevice if it is not a camera
// that streams single-planar frames.
std::unique_ptr<VideoDevice> open_video_device(const std::string& path);

}  // namespace raywalk::capture
