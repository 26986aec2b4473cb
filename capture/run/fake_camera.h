// A camera without hardware, for tests of code that uses the Camera interface.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/base/device_fault.h"
#include "capture/camera/camera.h"

namespace raywalk::capture {

// Takes `exposures` pictures of 64 x 32 pixels at each shot. A shot takes 400 ms of exposure and
// 100 ms of transfer on the clock. Faults are given by shot, counted from 1.
class FakeCamera final : public Camera {
 public:
  explicit FakeCamera(Clock* clock) : clock_(clock) {}

  int exposures = 1;
  bool keeps = false;
  std::map<int, FaultKind> faults{};        // by shot
  std::map<int, PanoramaSize> odd_sizes{};  // by shot
  std::map<int, int> fewer_pictures{};      // by shot: number of pictures instead
  std::map<int, std::string> files{};       // by shot: the bytes of the pictures instead
  std::function<void()> on_shot{};          // called at the moment of exposure

  // What the file of a picture holds: "shot 3 exposure 0". Shots are counted from 1, exposures
  // from 0.
  static std::string picture_text(int shot, int exposure) {
    return "shot " + std::to_string(shot) + " exposure " + std::to_string(exposure);
  }

  int shots() const { return shots_; }
  bool is_recording() const { return recording_; }
  int videos() const { return videos_; }

  std::string description() const override { return "fake camera"; }
  CameraReport report() override { return {.identity = "fake", .state = "idle"}; }
  std::string prepare(const ExposureSettings& /*exposure*/, const std::string& earlier) override {
    return earlier.empty() ? R"({"iso": 100})" : earlier;
  }
  Shot shoot(SteadyTime settled_at) override {
    ++shots_;
    if (on_shot) on_shot();
    EXPECT_LE(settled_at, clock_->now());
    if (faults.contains(shots_)) {
      throw DeviceFault(faults.at(shots_), "the fake camera fails; see the test");
    }
    Shot shot{.pictures = {},
              .triggered_at = clock_->wall_now(),
              .exposed_at = clock_->wall_now(),
              .exposing_ms = 400.0,
              .transfer_ms = 100.0};
    clock_->sleep(duration_from_ms(500.0));
    const int count = fewer_pictures.contains(shots_) ? fewer_pictures.at(shots_) : exposures;
    for (int i = 0; i < count && !keeps; ++i) {
      const PanoramaSize size =
          odd_sizes.contains(shots_) ? odd_sizes.at(shots_) : PanoramaSize{64, 32};
      shot.pictures.push_back(
          {.bytes = files.contains(shots_) ? files.at(shots_) : picture_text(shots_, i),
           .extension = "jpg",
           .camera_name = "",
           .size = size,
           .exposure = ""});
    }
    return shot;
  }
  bool keeps_pictures() const override { return keeps; }
  void start_video() override {
    recording_ = true;
    ++videos_;
  }
  void stop_video() override { recording_ = false; }

 private:
  Clock* clock_;
  int shots_ = 0;
  bool recording_ = false;
  int videos_ = 0;
};

}  // namespace raywalk::capture
