// The camera section of a configuration. configs/capture-*.yaml explain every key.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "capture/base/word_of.h"
#include "capture/camera/camera.h"

namespace raywalk::capture {

// How the camera is driven: over Open Spherical Camera (HTTP), as a Video4Linux2 device, or by its
// shutter line.
enum class CameraKind { kOsc, kV4l2, kGpio };
inline constexpr std::array kCameraKinds{CameraKind::kOsc, CameraKind::kV4l2, CameraKind::kGpio};

// 2:1 equirectangular, or two fisheye circles side by side.
enum class FrameKind { kPanorama, kDualFisheye };
inline constexpr std::array kFrameKinds{FrameKind::kPanorama, FrameKind::kDualFisheye};

enum class PixelFormat { kMjpg, kYuyv };
inline constexpr std::array kPixelFormats{PixelFormat::kMjpg, PixelFormat::kYuyv};

// The words of the configuration file; the session's database holds those of camera and frames.
constexpr std::string_view name_of(CameraKind kind) {
  return word_of(kind, {"osc", "v4l2", "gpio"});
}
constexpr std::string_view name_of(FrameKind frames) {
  return word_of(frames, {"panorama", "dual-fisheye"});
}
constexpr std::string_view name_of(PixelFormat format) { return word_of(format, {"mjpg", "yuyv"}); }

struct OscConfig {
  std::string url;  // "http://192.168.1.1"
  double connect_timeout_ms = 5000.0;
  double picture_timeout_ms = 60000.0;  // from the trigger to the picture being ready
  double poll_ms = 100.0;
};

struct V4l2Config {
  std::string device;  // "/dev/v4l/by-id/..."
  PixelFormat pixel_format = PixelFormat::kMjpg;
  double frame_timeout_ms = 3000.0;
  // A frame stamped less than this after the carriage settled is dropped.
  double exposure_ms = 40.0;
  int jpeg_quality = 95;  // of frames that arrive as yuyv
};

// The trigger section. Output lines of a GPIO chip to an opto-isolated shutter, and one line back.
// Lines are counted from 0 on their chip; -1: not wired.
struct TriggerConfig {
  std::string chip = "gpiochip0";  // in /dev, or a path
  int focus_line = -1;             // half-press
  int shutter_line = -1;           // full press
  int busy_line = -1;              // from the camera: active while it is busy
  bool active_low = false;         // the two outputs
  bool busy_active_low = false;
  double focus_ms = 300.0;  // half-press before the shutter
  double pulse_ms = 100.0;  // shutter held; cameras need 10 to 100
  double hold_ms = 2000.0;  // waited after a press without a busy line
  double busy_start_timeout_ms = 2000.0;
  double busy_end_timeout_ms = 30000.0;
  // For bracketed exposures: true if the camera takes one at each press (its bracketing set to
  // single shots), false if it takes all at one press.
  bool press_per_exposure = true;
};

struct CameraConfig {
  CameraKind kind = CameraKind::kOsc;
  FrameKind frames = FrameKind::kPanorama;
  int width_px = 0;  // of a frame; 0: the size of the first frame holds for the rest
  int height_px = 0;
  // For the estimates of the plan; 0: unknown.
  double card_gb = 0.0;      // size of a storage card, 10^9 bytes
  int battery_pictures = 0;  // that a charge lasts for
  double battery_min = 0.0;  // that a charge lasts for
  ExposureSettings exposure{};
  OscConfig osc{};
  V4l2Config v4l2{};
  TriggerConfig trigger{};
};

}  // namespace raywalk::capture
