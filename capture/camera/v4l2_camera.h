// A USB or HDMI camera on Video4Linux2 that streams 360-degree frames.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "capture/camera/camera.h"
#include "capture/camera/camera_config.h"
#include "capture/camera/v4l2_exposure.h"
#include "capture/camera/video_device.h"

namespace raywalk::capture {

// Streams from prepare() on. A picture is the first frame whose driver timestamp lies at least
// V4l2Config::exposure_ms, or the locked exposure time if longer, after the carriage settled:
// frames of the previous station may still be queued. Damaged frames are skipped until the timeout.
class V4l2Camera final : public Camera {
 public:
  V4l2Camera(const CameraConfig& config, std::unique_ptr<VideoDevice> device, Clock* clock);

  std::string description() const override;
  // Throws DeviceFault kWrongDevice if the driver offers another size or pixel format.
  CameraReport report() override;
  // Starts to stream and waits for a frame. Throws as report() and shoot() do.
  std::string prepare(const ExposureSettings& exposure, const std::string& earlier) override;
  // Throws DeviceFault: kTimeout without a frame within frame_timeout_ms, kBadPicture if all were
  // damaged, kWrongDevice if frames have no CLOCK_MONOTONIC timestamp, kExposure if the locked
  // settings changed, kNoContact if the camera is unplugged.
  Shot shoot(SteadyTime settled_at) override;

 private:
  struct Taken {
    Picture picture;
    SteadyTime stamped_at;
  };

  VideoFormat expected(const VideoFormat& offered, PanoramaSize asked) const;
  PanoramaSize asked_size();
  void start();
  void let_camera_measure();
  // The first good frame stamped at `not_before` or later, after `passed_over` such.
  Taken take(SteadyTime not_before, int passed_over);
  // The frame as a file; none if it is damaged, with the reason in `damage`.
  std::optional<Picture> picture_of(const VideoFrame& frame, std::string* damage) const;
  DeviceFault fault(FaultKind kind, const std::string& what) const;

  CameraConfig config_;
  std::string pixels_;  // "MJPG" or "YUYV"
  std::unique_ptr<VideoDevice> device_;
  Clock* clock_;
  V4l2Exposure exposure_;
  std::vector<double> bracket_ev_{0.0};
  std::optional<VideoFormat> format_;  // once streaming
};

}  // namespace raywalk::capture
