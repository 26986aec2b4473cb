// A video capture device as the programs use it: the Video4Linux2 API's memory-mapped streaming
// (v4l2_device.h), or a fake (fake_video_device.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "capture/base/clock.h"
#include "core/geometry/sphere.h"

namespace raywalk::capture {

struct VideoIdentity {
  std::string driver;  // "uvcvideo 6.1.55"
  std::string card;    // the model's name
  std::string bus;     // where it is plugged in
};

// How Y'CbCr samples stand for colours; luma coefficients kr, kb of the red and blue primaries.
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

// A frame as the driver gave it. `bytes` stay valid until the next call of next_frame or stop.
struct VideoFrame {
  std::span<const std::byte> bytes;
  // The driver's stamp; none where it is not taken from CLOCK_MONOTONIC. What moment of the frame
  // it marks differs: uvcvideo stamps the arrival of its first packet, others that of its last.
  std::optional<SteadyTime> stamped_at;
  bool is_damaged = false;  // by the driver's own account
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

// The words of messages and of the JSON kept for a session: "exposure_100us", "gain", ...
std::string name_of(VideoControl control);

struct ControlRange {
  int least = 0;
  int most = 0;
  int step = 1;
};

// Calls throw DeviceFault: kNoContact where the device has gone or fails, kBusy where another
// program streams from it.
class VideoDevice {
 public:
  VideoDevice() = default;
  VideoDevice(const VideoDevice&) = delete;
  VideoDevice& operator=(const VideoDevice&) = delete;
  virtual ~VideoDevice() = default;

  // The name the user gave, for messages.
  virtual std::string path() const = 0;
  virtual VideoIdentity identity() const = 0;

  // Of the frames it is set to give.
  virtual PanoramaSize current_size() = 0;
  // What the driver makes of pixels and size: the nearest it can do, which may be neither. Trying
  // changes nothing; setting it is possible before start only.
  virtual VideoFormat try_format(const std::string& pixels, PanoramaSize size) = 0;
  virtual VideoFormat set_format(const std::string& pixels, PanoramaSize size) = 0;

  // None where the camera has no such control or cannot use it now.
  virtual std::optional<ControlRange> range_of(VideoControl control) = 0;
  virtual int control(VideoControl control) = 0;
  // False where the driver refuses the value. Drivers round it: read it back.
  virtual bool set_control(VideoControl control, int value) = 0;

  // Frames are taken from now on, into as many buffers as the driver needs, at least `buffers`.
  virtual void start(int buffers) = 0;
  virtual void stop() = 0;
  // The oldest frame not yet taken: frames taken long ago come first when nobody fetched them. None
  // once `timeout` has passed, or sooner where a signal arrives.
  virtual std::optional<VideoFrame> next_frame(Duration timeout) = 0;
};

}  // namespace raywalk::capture
