// `raywalk-capture check`: talks to every device of a configuration and moves nothing.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

struct DeviceCheck {
  std::string device;  // "slider", "camera", "disk"
  bool usable = false;
  std::string text;  // identity and state, or what is wrong and what to do
};

// Asks all of them, also where one fails. `disk` is where sessions will be written.
std::vector<DeviceCheck> check_devices(const CaptureConfig& config,
                                       const std::filesystem::path& disk);

// What a run refuses before it begins rather than in its middle. Throw Error: the camera tells that
// its card has room for fewer pictures; less is free on the directory's disk than the pictures and
// run.least_free_mb take (as far as a picture's size is known).
void require_room_on_card(const CameraReport& report, std::size_t pictures);
void require_room_on_disk(const std::filesystem::path& directory, std::size_t pictures,
                          const CapturePlan& plan, const CaptureConfig& config);

// The checks as lines for people, one per device. `all_usable` tells whether a run can begin.
std::string text_of(const std::vector<DeviceCheck>& checks);
bool all_usable(const std::vector<DeviceCheck>& checks);

}  // namespace raywalk::capture
