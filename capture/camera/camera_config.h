// What a user says of the camera. configs/capture-*.yaml explain every key.
#pragma once

#include <string>

#include "capture/camera/camera.h"
#include "capture/trigger/trigger_config.h"

namespace raywalk::capture {

struct OscConfig {
  std::string url;  // "http://192.168.1.1"
  double connect_timeout_ms = 5000.0;
  double picture_timeout_ms = 60000.0;  // from the trigger to the picture being ready
  double poll_ms = 100.0;
};

struct V4l2Config {
  std::string device;                 // "/dev/v4l/by-id/..."
  std::string pixel_format = "mjpg";  // "mjpg" or "yuyv"
  double frame_timeout_ms = 3000.0;
  double exposure_ms =
      40.0;               // a frame stamped less than this after the carriage settled is dropped
  int jpeg_quality = 95;  // of frames that arrive as yuyv
};

struct CameraConfig {
  std::string kind = "osc";         // "osc", "v4l2" or "gpio"
  std::string frames = "panorama";  // "panorama" (2:1 equirectangular) or "dual-fisheye"
  int width_px = 0;                 // of a frame; 0: take what comes, and hold the rest to it
  int height_px = 0;
  ExposureSettings exposure{};
  OscConfig osc{};
  V4l2Config v4l2{};
  TriggerConfig trigger{};
};

}  // namespace raywalk::capture
