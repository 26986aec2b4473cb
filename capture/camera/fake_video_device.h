// For tests: a video device with configured faults. Frames follow a Clock; with a ManualClock
// nothing waits.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "capture/camera/video_device.h"

namespace raywalk::capture {

// Frames are counted from 1; 0 disables a fault.
struct FakeVideoSettings {
  int width_px = 64;
  int height_px = 32;
  bool any_size = true;  // else every other size snaps to width_px x height_px
  std::string pixels{};  // "MJPG", "YUYV": any other format snaps to it; empty: it has all
  double frames_per_second = 25.0;
  int line_padding_bytes = 0;    // of YUYV
  bool monotonic_stamps = true;  // else of a clock that the host does not know

  bool controls = true;           // exposure, gain and white balance
  int sensor_exposure = 300;      // measured by the automatic exposure, in 0.1 ms
  int exposure_delay_frames = 2;  // until a new exposure time takes effect
  std::string refused_control{};  // as named by name_of(VideoControl)
  int drift_after_frame = 0;      // the exposure changes after this frame

  int damaged_every = 0;       // with the driver's error flag
  int short_every = 0;         // truncated to half, without the flag
  int empty_every = 0;         // no bytes, without the flag
  int gone_after_frame = 0;    // ENODEV after this frame
  int silent_after_frame = 0;  // no more frames after this one
  bool taken = false;          // another program streams from it
};

// The scene: a BGR picture (CV_8UC3) of the given size, exposed until the time `exposed` for
// `exposure_100us` times 0.1 ms.
using FakeScene = std::function<cv::Mat(SteadyTime exposed, int exposure_100us, PanoramaSize size)>;

// Without a scene, frames are grey and proportional in brightness to the exposure time.
class FakeVideoDevice final : public VideoDevice {
 public:
  FakeVideoDevice(FakeVideoSettings settings, Clock* clock, FakeScene scene = {});

  std::string path() const override { return "/dev/video-fake"; }
  VideoIdentity identity() const override;
  PanoramaSize current_size() override;
  VideoFormat try_format(const std::string& pixels, PanoramaSize size) override;
  VideoFormat set_format(const std::string& pixels, PanoramaSize size) override;
  std::optional<ControlRange> range_of(VideoControl control) override;
  int control(VideoControl control) override;
  bool set_control(VideoControl control, int value) override;
  void start(int buffers) override;
  std::optional<VideoFrame> next_frame(Duration timeout) override;

 private:
  struct Exposed {
    SteadyTime at{};
    int number = 0;  // from 1
    int exposure_100us = 0;
  };

  void expose_until_now();
  int exposure_now() const;
  VideoFrame frame_of(const Exposed& exposed);
  std::string encoded(const cv::Mat& picture) const;

  FakeVideoSettings settings_;
  Clock* clock_;
  FakeScene scene_;
  VideoFormat format_;
  std::map<VideoControl, int> controls_;
  Duration period_{};
  SteadyTime next_exposed_{};
  int frames_ = 0;  // number of frames exposed into a buffer
  int free_buffers_ = 0;
  bool lends_ = false;
  std::deque<Exposed> queued_;
  std::deque<int> exposures_;  // of the next frames, while a change is pending
  std::string bytes_;          // of the frame returned last
};

}  // namespace raywalk::capture
